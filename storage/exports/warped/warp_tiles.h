// WarpTiles: the colours of a finished tileset as a cloud-optimised GeoTIFF in another coordinate system or
// resolution. The pixels are resampled (cubic; averaged where they become larger) from the zoom that is just
// fine enough, and encoded as JPEG with a one-bit mask; overviews are means of the level below. The same
// bytes for any number of threads, eight of which are used. Memory: some 150 MiB a thread. Encoded blocks
// lie beside `path` until all are there. Published by rename. Blocking. Errors: kUnprocessable
// (TargetGrid's), kCorrupt (a damaged tile, or nothing is shown at all), kIo, kOutOfSpace, kCancelled.
#pragma once

#include <filesystem>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/geo/lat_lon_bounds.h"
#include "storage/exports/warp_target.h"
#include "storage/tilesets/tile_source.h"

namespace skyquilt::storage {

struct WarpTilesOptions {
  geo::LatLonBounds bounds;
  int min_zoom = 0, max_zoom = 0;  // of the tileset
  WarpTarget target;
  int jpeg_quality = 85;
  int threads = 0;  // 0 = all cores
  const char* message = "writing the GeoTIFF";
};

Result<void> WarpTiles(MapTiles& tiles, const std::filesystem::path& path, const WarpTilesOptions& options,
                       Progress& progress);

}  // namespace skyquilt::storage
