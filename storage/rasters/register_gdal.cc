#include "storage/rasters/register_gdal.h"

#include <cpl_conv.h>
#include <gdal_priv.h>

#include <cstdint>
#include <mutex>

namespace skyquilt::storage {

void RegisterGdalOnce() {
  static std::once_flag once;
  std::call_once(once, [] {
    CPLSetConfigOption("GDAL_PAM_ENABLED", "NO");
    // GDAL would take a twentieth of the machine's memory for blocks; a warp from north to south needs far
    // less.
    GDALSetCacheMax64(std::int64_t{96} << 20);
    GDALAllRegister();
  });
}

}  // namespace skyquilt::storage
