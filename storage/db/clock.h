// The catalogue's time: UTC in microseconds. Passed in by the caller wherever a rule depends on it (leases),
// so that tests need not wait.
#pragma once

#include <chrono>
#include <cstdint>

namespace skyquilt::storage {

using Time = std::chrono::sys_time<std::chrono::microseconds>;

inline Time Now() { return std::chrono::floor<std::chrono::microseconds>(std::chrono::system_clock::now()); }
inline std::int64_t ToUs(Time time) { return time.time_since_epoch().count(); }
inline Time FromUs(std::int64_t us) { return Time(std::chrono::microseconds(us)); }

}  // namespace skyquilt::storage
