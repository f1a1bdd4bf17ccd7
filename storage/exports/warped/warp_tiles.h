// WarpTiles: the colours of a finished tileset as a cloud-optimised GeoTIFF in another coordinate system or
// resolution. The pixels are resampled (cubic; averaged where they become larger) from the zoom that is just
// fine enough, and encoded as JPEG with a one-bit mask; overviews are means of the level below. The same
// bytes for any number of threads, eight of which are used. Memory: some 150 MiB a thread. Encoded blocks
// lie beside `path` until all are there. Published by rename. Blocking. Errors: kUnprocessable
// (TargetGrid's), kCorrupt (a damaged tile, or nothing is shown at all), kIo, kOutOfSpace, kCancelled.
// WriteUtmGeotiff: the same of an MBTiles in the UTM zone of its middle.
#pragma once

#include <filesystem>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/geo/lat_lon.h"
#include "core/geo/lat_lon_bounds.h"
#include "storage/tilesets/tile_source.h"

namespace skyquilt::storage {

// The system and pixels that a map's raster is brought to, be it of colours or of values (warp_geotiff.h).
struct WarpTarget {
  int epsg = 3857;
  double pixel_x = 1.0, pixel_y = 1.0;  // in units of that system
  bool is_coarser = false;              // than what is read
};

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

// The EPSG code of the UTM zone of a place (326xx, 327xx), Norway's and Svalbard's wider zones included.
// kUnprocessable beyond 84 degrees north and 80 south.
Result<int> UtmEpsg(const geo::LatLon& position);

// For programs that measure in metres on the ground. The middle of the bounds decides the zone, and with it
// `options.target.epsg`.
Result<void> WriteUtmGeotiff(const std::filesystem::path& mbtiles, const std::filesystem::path& path,
                             WarpTilesOptions options, Progress& progress);

}  // namespace skyquilt::storage
