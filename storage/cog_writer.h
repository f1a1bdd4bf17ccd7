// WriteCog: a finished MBTiles as a cloud-optimised GeoTIFF in EPSG:3857, tiled like the web map (GDAL's
// GoogleMapsCompatible), JPEG inside with an internal mask at the fringe. Streams through GDAL's COG driver; memory is
// GDAL's block cache. Written under a temporary name and published by rename. Blocking.
// Errors: kIo, kOutOfSpace, kCancelled.
#pragma once

#include <filesystem>

#include "core/base/progress.h"
#include "core/base/result.h"

namespace skyquilt::storage {

struct CogOptions {
  int max_zoom = 0;      // the MBTiles' finest zoom
  int jpeg_quality = 85;
  int threads = 0;       // 0 = all cores
};

Result<void> WriteCog(const std::filesystem::path& mbtiles, const std::filesystem::path& path,
                      const CogOptions& options, Progress& progress);

}  // namespace skyquilt::storage
