// OpenRasters: the rasters beside maps (bands, heights), opened once and kept while they are read: of the
// kMaxOpen asked for last. That a map has none is remembered too, since a revision never changes. Any thread.
// Errors: those of opening, which are told to whoever asks and tried again next time.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <string>

#include "core/base/result.h"
#include "core/base/try.h"

namespace skyquilt::storage {

template <typename Raster>
class OpenRasters {
 public:
  static constexpr std::size_t kMaxOpen = 64;

  // Null: the map has none. `open` gives a Result of the raster, null where there is none.
  template <typename Open>
  Result<std::shared_ptr<Raster>> Get(const std::string& flight_id, std::int64_t revision, const Open& open) {
    const auto is_it = [&](const Opened& opened) {
      return opened.revision == revision && opened.flight_id == flight_id;
    };
    {
      const std::lock_guard lock(mutex_);
      const auto found = std::find_if(opened_.begin(), opened_.end(), is_it);
      if (found != opened_.end()) {
        opened_.splice(opened_.begin(), opened_, found);
        return found->raster;
      }
    }
    // Two who ask at the same time open it twice; the later one is forgotten.
    SKYQUILT_TRY_ASSIGN(std::shared_ptr<Raster> raster, open());
    const std::lock_guard lock(mutex_);
    const auto found = std::find_if(opened_.begin(), opened_.end(), is_it);
    if (found != opened_.end()) return found->raster;
    // An earlier map of the flight is read no more.
    opened_.remove_if(
        [&](const Opened& opened) { return opened.flight_id == flight_id && opened.revision < revision; });
    opened_.push_front({flight_id, revision, raster});
    if (opened_.size() > kMaxOpen) opened_.pop_back();
    return raster;
  }

 private:
  struct Opened {
    std::string flight_id;
    std::int64_t revision = 0;
    std::shared_ptr<Raster> raster;
  };
  std::mutex mutex_;
  std::list<Opened> opened_;  // the last asked for first
};

}  // namespace skyquilt::storage
