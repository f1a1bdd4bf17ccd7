#include "server/routing/request_log.h"

#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <nlohmann/json.hpp>

#include "api/json/json_codec.h"
#include "core/base/text/json_io.h"

namespace skyquilt::server {
namespace {

// One write a line, so that lines of several processes do not mix.
void WriteLine(const char* level, const nlohmann::ordered_json& members) {
  nlohmann::ordered_json values = {{"time", api::FormatTime(storage::Now())}, {"level", level}};
  values.update(members);
  const std::string line = JsonText(values) + "\n";
  // A log that cannot be written has nowhere to say so.
  [[maybe_unused]] const ssize_t wrote = write(STDERR_FILENO, line.data(), line.size());
}

}  // namespace

std::string NextRequestId() {
  static const auto run =
      static_cast<std::uint64_t>(std::chrono::system_clock::now().time_since_epoch().count());
  static std::atomic<std::uint64_t> next{0};
  return fmt::format("{:x}-{:x}", run & 0xffffffffffU, next.fetch_add(1, std::memory_order_relaxed));
}

void LogResponse(std::string_view request_id, std::string_view method, std::string_view path, int status,
                 std::string_view what) {
  WriteLine(
      "error",
      {{"request_id", request_id}, {"method", method}, {"path", path}, {"status", status}, {"what", what}});
}

void LogFailure(std::string_view request_id, std::string_view where, std::string_view what) {
  WriteLine("error", {{"request_id", request_id}, {"where", where}, {"what", what}});
}

void LogFailure(std::string_view request_id, std::string_view where, const Error& why) {
  LogFailure(request_id, where, why.message + " " + why.detail);
}

void LogUncaught(const std::exception_ptr& failure) {
  if (failure == nullptr) return;
  try {
    std::rethrow_exception(failure);
  } catch (const std::exception& known) {
    LogFailure("-", "connection", known.what());
  }
}

void LogEvent(std::string_view what) { WriteLine("info", {{"what", what}}); }

}  // namespace skyquilt::server
