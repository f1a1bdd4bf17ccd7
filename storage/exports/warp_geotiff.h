// WarpGeotiff: a finished GeoTIFF of values once more in another coordinate system or resolution (colours:
// warped/warp_tiles.h). The pixels are resampled as WarpedPixels says and encoded anew, by GDAL, block by
// block. Cloud-optimised. Memory: GDAL's block cache and warp buffer. What it puts down meanwhile lies beside
// `path`: the pixels without loss, some eight times the bytes of the outcome. Published by rename. Blocking.
// Errors: kIo, kOutOfSpace, kCancelled.
#pragma once

#include <filesystem>
#include <optional>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/geo/bounds.h"
#include "core/geo/lat_lon_bounds.h"
#include "storage/exports/warped/warp_tiles.h"

namespace skyquilt::storage {

enum class WarpedPixels {
  kHeights,  // in metres: bilinear
  kCounts,   // the nearest
  kValues,   // of an index: bilinear, averaged where they become larger
};

struct WarpOptions {
  WarpedPixels pixels = WarpedPixels::kValues;
  WarpTarget target;
  std::optional<geo::LatLonBounds>
      bounds;  // all of them, whichever way their edges bend; absent: of all there is
  // The pixels of the source as they are, in its own system: nothing but the file's form is new. Those of the
  // window, in that system.
  std::optional<geo::Bounds2> window;
  int threads = 0;  // 0 = all cores
  const char* message = "writing the GeoTIFF";
};

Result<void> WarpGeotiff(const std::filesystem::path& geotiff, const std::filesystem::path& path,
                         const WarpOptions& options, Progress& progress);

}  // namespace skyquilt::storage
