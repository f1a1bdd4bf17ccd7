#include "storage/exports/utm_writer.h"

#include "core/base/try.h"
#include "core/geo/crs/reference_system.h"
#include "storage/exports/warp_geotiff.h"

namespace skyquilt::storage {

Result<int> UtmEpsg(const geo::LatLon& position) {
  if (!(position.lat_deg >= -80.0 && position.lat_deg <= 84.0)) {
    return Error{ErrorCode::kUnprocessable,
                 "UTM ends at 80 degrees south and 84 north; leave out --utm, and dsm of --formats, here",
                 ""};
  }
  return geo::UtmCodeOf(position);
}

Result<void> WriteUtmGeotiff(const std::filesystem::path& cog, const std::filesystem::path& path,
                             const UtmOptions& options, Progress& progress) {
  SKYQUILT_TRY_ASSIGN(const int epsg, UtmEpsg(options.middle));
  WarpOptions warp;
  warp.epsg = epsg;
  warp.pixel_x = warp.pixel_y = options.pixel_m;
  warp.jpeg_quality = options.jpeg_quality;
  warp.threads = options.threads;
  warp.message = "writing the UTM GeoTIFF";
  return WarpGeotiff(cog, path, warp, progress);
}

}  // namespace skyquilt::storage
