#include "storage/exports/utm_writer.h"

#include "core/base/try.h"
#include "core/geo/crs/reference_system.h"
#include "storage/exports/warped/warp_tiles.h"
#include "storage/tilesets/mbtiles_reader.h"

namespace skyquilt::storage {

Result<int> UtmEpsg(const geo::LatLon& position) {
  if (!(position.lat_deg >= -80.0 && position.lat_deg <= 84.0)) {
    return Error{ErrorCode::kUnprocessable,
                 "UTM ends at 80 degrees south and 84 north; leave out --utm, and dsm of --formats, here",
                 ""};
  }
  return geo::UtmCodeOf(position);
}

Result<void> WriteUtmGeotiff(const std::filesystem::path& mbtiles, const std::filesystem::path& path,
                             const UtmOptions& options, Progress& progress) {
  WarpTilesOptions warp;
  SKYQUILT_TRY_ASSIGN(warp.target.epsg, UtmEpsg(options.bounds.Middle()));
  warp.bounds = options.bounds;
  warp.min_zoom = options.min_zoom;
  warp.max_zoom = options.max_zoom;
  warp.target.pixel_x = warp.target.pixel_y = options.pixel_m;
  warp.jpeg_quality = options.jpeg_quality;
  warp.threads = options.threads;
  warp.message = "writing the UTM GeoTIFF";
  SKYQUILT_TRY_ASSIGN(const auto tiles, MbtilesReader::Open(mbtiles));
  return WarpTiles(*tiles, path, warp, progress);
}

}  // namespace skyquilt::storage
