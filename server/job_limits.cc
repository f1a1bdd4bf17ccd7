#include "server/job_limits.h"

#include "core/base/parallel_for.h"

namespace skyquilt::server {
namespace {

constexpr std::int64_t kBaseS = 600;
constexpr std::int64_t kFileS = 60;
constexpr std::int64_t kMibS = 1;
constexpr std::int64_t kBaseMemoryBytes = std::int64_t{4} << 30;
constexpr std::int64_t kFileMemoryBytes = std::int64_t{2} << 20;

}  // namespace

JobLimits LimitsOfJob(std::int64_t files, std::int64_t bytes, const pipeline::MosaicOptions& options,
                      std::optional<std::chrono::seconds> timeout) {
  JobLimits limits;
  const std::int64_t scaled_s = kBaseS + kFileS * files + kMibS * (bytes >> 20);
  limits.wall = timeout.value_or(std::chrono::seconds(scaled_s));
  limits.cpu_s = timeout ? timeout->count() * ThreadCount(options.threads) : 2 * scaled_s;
  limits.memory_bytes = options.max_memory_bytes + kBaseMemoryBytes + kFileMemoryBytes * files;
  return limits;
}

}  // namespace skyquilt::server
