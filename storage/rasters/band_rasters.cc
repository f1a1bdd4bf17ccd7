#include "storage/rasters/band_rasters.h"

#include <algorithm>
#include <utility>

#include "core/base/try.h"

namespace skyquilt::storage {
namespace {

// The file stays under its path for as long as somebody reads it.
std::shared_ptr<BandRaster> KeepingFile(std::shared_ptr<BandRaster> raster, const LocalBlob& file) {
  BandRaster* const shown = raster.get();
  return {shown, [raster = std::move(raster), in_use = file.in_use](BandRaster*) mutable { raster.reset(); }};
}

}  // namespace

Result<std::shared_ptr<BandRaster>> BandRasters::Get(const std::string& flight_id, std::int64_t revision,
                                                     const std::function<Result<LocalBlob>()>& find) {
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
  std::shared_ptr<BandRaster> raster;
  const Result<LocalBlob> file = find();
  if (file) {
    SKYQUILT_TRY_ASSIGN(std::shared_ptr<BandRaster> opened, BandRaster::Open(file->path));
    raster = KeepingFile(std::move(opened), *file);
  } else if (file.error().code != ErrorCode::kNotFound) {
    return file.error();
  }
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

}  // namespace skyquilt::storage
