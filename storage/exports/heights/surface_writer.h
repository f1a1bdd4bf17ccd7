// SurfaceWriter: heights of the map's cells as two cloud-optimised GeoTIFFs in its UTM zone: dsm.tif, float32
// metres above the ellipsoid as the flight's records have it, or from where a survey counts, NaN where no
// photo shows the ground, and beside it dsm_photos.tif, one byte a cell: how many photos agree on the height,
// 0 where it was filled from around. On request the ground below what stands on it as well: dtm.tif,
// likewise, and dtm_ground.tif, 1 where that ground was seen and measured, 0 where it is bridged. Blocks go
// to temporary files as they come, in the flight's own frame, and are resampled on Publish (bilinear; the
// nearest); all files get their names when the last is finished. Memory: GDAL's block cache and warp buffer.
// One thread. Errors: kUnprocessable (no UTM zone so far north or south, fields far apart), kIo, kOutOfSpace,
// kCancelled.
#pragma once

#include <filesystem>
#include <memory>

#include "core/base/progress.h"
#include "core/geo/lat_lon.h"
#include "core/geo/local_frame.h"
#include "core/surface/dense_surface.h"
#include "core/surface/ground_below.h"

namespace skyquilt::storage {

class SurfaceWriter {
 public:
  // Of a grid whose cells lie about mean_z_m high in the frame. `map_middle` says the zone, so that it is
  // that of the map's own UTM GeoTIFF. `threads`: 0 = all cores. `ground`: null where that is not wanted;
  // given its parts in rows from the north. `raised_m` is added to all heights.
  SurfaceWriter(const std::filesystem::path& folder, const geo::LocalFrame& frame,
                const geo::LatLon& map_middle, const surface::SurfaceGrid& grid, double mean_z_m, int threads,
                surface::GroundBelow* ground, Progress& progress, double raised_m = 0.0);
  ~SurfaceWriter();

  Result<void> Begin();
  Result<void> Put(const surface::SurfaceBlock& block);
  // After the last block.
  Result<void> Publish();

  // Of the cells that a photo shows, the share whose height was measured; 0 where there are none.
  double MeasuredShare() const;

 private:
  struct Work;
  std::unique_ptr<Work> work_;
};

}  // namespace skyquilt::storage
