#include "storage/exports/utm_writer.h"

#include <cmath>

#include "core/base/try.h"
#include "storage/exports/warp_geotiff.h"

namespace skyquilt::storage {

Result<int> UtmEpsg(const geo::LatLon& position) {
  const double lat_deg = position.lat_deg;
  const double lon_deg = std::remainder(position.lon_deg, 360.0);
  if (!(lat_deg >= -80.0 && lat_deg <= 84.0)) {
    return Error{ErrorCode::kUnprocessable, "UTM ends at 80 degrees south and 84 north; leave out --utm here",
                 ""};
  }
  int zone = static_cast<int>(std::floor((lon_deg + 180.0) / 6.0)) % 60 + 1;
  if (lat_deg >= 56.0 && lat_deg < 64.0 && lon_deg >= 3.0 && lon_deg < 12.0) zone = 32;
  if (lat_deg >= 72.0 && lon_deg >= 0.0 && lon_deg < 42.0) {
    zone = lon_deg < 9.0 ? 31 : lon_deg < 21.0 ? 33 : lon_deg < 33.0 ? 35 : 37;
  }
  return (lat_deg < 0.0 ? 32700 : 32600) + zone;
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
