// WriteUtmGeotiff: a finished MBTiles as a cloud-optimised GeoTIFF in the UTM zone of its middle (EPSG:326xx,
// 327xx), for programs that measure in metres on the ground: WarpTiles with its memory and errors, and
// kUnprocessable beyond 84 degrees north and 80 south. Published by rename. Blocking.
#pragma once

#include <filesystem>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/geo/lat_lon.h"
#include "core/geo/lat_lon_bounds.h"

namespace skyquilt::storage {

struct UtmOptions {
  geo::LatLonBounds bounds;        // of the map; their middle decides the zone
  int min_zoom = 0, max_zoom = 0;  // that it has
  double pixel_m = 0.05;           // on the ground
  int jpeg_quality = 85;
  int threads = 0;  // 0 = all cores
};

// The EPSG code of the UTM zone of a place, Norway's and Svalbard's wider zones included.
Result<int> UtmEpsg(const geo::LatLon& position);

Result<void> WriteUtmGeotiff(const std::filesystem::path& mbtiles, const std::filesystem::path& path,
                             const UtmOptions& options, Progress& progress);

}  // namespace skyquilt::storage
