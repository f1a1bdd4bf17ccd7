// WriteUtmGeotiff: a finished cloud-optimised GeoTIFF once more in the UTM zone of its middle (EPSG:326xx,
// 327xx), for programs that measure in metres on the ground. The pixels are resampled (cubic) and encoded
// anew, by GDAL, for no tile of one grid is a tile of the other. Itself cloud-optimised. Memory: GDAL's block
// cache and warp buffer. Published by rename. Blocking. Errors: kIo, kOutOfSpace, kCancelled, kUnprocessable
// beyond 84 degrees north and 80 south.
#pragma once

#include <filesystem>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/geo/lat_lon.h"

namespace skyquilt::storage {

struct UtmOptions {
  geo::LatLon middle;     // decides the zone
  double pixel_m = 0.05;  // on the ground
  int jpeg_quality = 85;
  int threads = 0;  // 0 = all cores
};

// The EPSG code of the UTM zone of a place, Norway's and Svalbard's wider zones included.
Result<int> UtmEpsg(const geo::LatLon& position);

Result<void> WriteUtmGeotiff(const std::filesystem::path& cog, const std::filesystem::path& path,
                             const UtmOptions& options, Progress& progress);

}  // namespace skyquilt::storage
