// PerRevision: what was found out of a flight's map, kept since a revision never changes: of the last
// kMaxKept flights that were asked of, one revision each. Any thread. Errors: those of finding out, which are
// told to whoever asks and tried again next time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <string>
#include <unordered_map>

#include "core/base/result.h"
#include "core/base/try.h"

namespace skyquilt::api {

template <typename Value>
class PerRevision {
 public:
  static constexpr std::size_t kMaxKept = 50'000;

  // `find` gives a Result of the value.
  template <typename Find>
  Result<Value> Of(const std::string& flight_id, std::int64_t revision, const Find& find) {
    {
      const std::lock_guard lock(mutex_);
      const auto found = kept_.find(flight_id);
      if (found != kept_.end() && found->second.revision == revision) return found->second.value;
    }
    SKYQUILT_TRY_ASSIGN(Value value, find());
    const std::lock_guard lock(mutex_);
    if (kept_.size() >= kMaxKept) kept_.erase(kept_.begin());
    kept_[flight_id] = {revision, value};
    return value;
  }

 private:
  struct Kept {
    std::int64_t revision = 0;
    Value value;
  };
  std::mutex mutex_;
  std::unordered_map<std::string, Kept> kept_;  // by flight
};

}  // namespace skyquilt::api
