#include "server/jobs/job_limits.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <string>

#include "core/base/parallel_for.h"
#include "core/base/text/plain_text.h"
#include "core/video/take_frames.h"

namespace skyquilt::server {
namespace {

constexpr std::int64_t kBaseS = 600;
constexpr std::int64_t kFileS = 60;
constexpr std::int64_t kMibS = 1;
constexpr std::int64_t kBaseMemoryBytes = std::int64_t{4} << 30;
constexpr std::int64_t kFileMemoryBytes = std::int64_t{2} << 20;

// A number in a file; nothing where there is none ("max").
std::optional<std::int64_t> NumberIn(const char* path) {
  std::int64_t number = 0;
  std::ifstream file(path);
  if (file >> number) return number;
  return std::nullopt;
}

}  // namespace

bool IsNameOfFilm(std::string_view name) {
  constexpr std::array<std::string_view, 9> kEnds = {".mp4", ".mov", ".m4v", ".lrf", ".lrv",
                                                     ".avi", ".mkv", ".ts",  ".mts"};
  const std::string lower = LowerCase(name);
  return std::any_of(kEnds.begin(), kEnds.end(), [&](std::string_view end) { return lower.ends_with(end); });
}

std::int64_t MostPhotosIn(std::string_view name, std::int64_t bytes) {
  constexpr std::int64_t kFramesAMib = 4;  // two a second of 4 Mbit
  if (!IsNameOfFilm(name)) return 1;
  const std::int64_t most_frames = video::TakeFramesOptions().max_frames;
  return std::clamp(kFramesAMib * (bytes >> 20), std::int64_t{1}, most_frames);
}

JobLimits LimitsOfJob(std::int64_t files, std::int64_t bytes, const pipeline::MosaicOptions& options,
                      const GivenLimits& given) {
  JobLimits limits;
  const std::int64_t scaled_s = kBaseS + kFileS * files + kMibS * (bytes >> 20);
  limits.wall = given.timeout.value_or(std::chrono::seconds(scaled_s));
  limits.cpu_s = given.timeout ? given.timeout->count() * ThreadCount(options.threads) : 2 * scaled_s;
  limits.memory_bytes = options.max_memory_bytes + kBaseMemoryBytes + kFileMemoryBytes * files;
  if (given.machine_memory_bytes > 0)
    limits.memory_bytes = std::min(limits.memory_bytes, given.machine_memory_bytes / 4 * 3);
  limits.memory_bytes = given.memory_bytes.value_or(limits.memory_bytes);
  return limits;
}

std::int64_t MemoryOfThisMachine() {
  std::int64_t bytes = std::int64_t{sysconf(_SC_PHYS_PAGES)} * sysconf(_SC_PAGESIZE);
  for (const char* limit : {"/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"}) {
    if (const auto given = NumberIn(limit)) bytes = std::min(bytes, *given);
  }
  return bytes;
}

}  // namespace skyquilt::server
