#include "storage/gdal_guard.h"

#include <cpl_conv.h>
#include <gdal_priv.h>

#include <cstdint>
#include <mutex>

namespace skyquilt::storage {

void RegisterGdalOnce() {
  static std::once_flag once;
  std::call_once(once, [] {
    CPLSetConfigOption("GDAL_DISABLE_READDIR_ON_OPEN", "EMPTY_DIR");
    CPLSetConfigOption("GDAL_PAM_ENABLED", "NO");
    CPLSetConfigOption("CPL_VSIL_CURL_ALLOWED_EXTENSIONS", ".none");
    // GDAL would take a twentieth of the machine's memory for blocks; a stream of tiles needs far less.
    GDALSetCacheMax64(std::int64_t{96} << 20);
    GDALAllRegister();
  });
}

}  // namespace skyquilt::storage
