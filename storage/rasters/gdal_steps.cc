#include "storage/rasters/gdal_steps.h"

#include <cpl_error.h>
#include <gdal_priv.h>

#include <string>
#include <system_error>

namespace skyquilt::storage {

int ForwardGdalProgress(double fraction, const char*, void* step) {
  auto& told = *static_cast<GdalStep*>(step);
  told.progress.Report(told.from + fraction * (told.to - told.from), told.message);
  return told.progress.IsCancelled() ? FALSE : TRUE;
}

TemporaryTiff::~TemporaryTiff() {
  std::error_code gone;  // what stays is overwritten by the next run
  std::filesystem::remove(path_, gone);
}

Error LastGdalError(const Progress& progress) {
  if (progress.IsCancelled()) return {ErrorCode::kCancelled, "the job was cancelled", ""};
  const std::string detail = CPLGetLastErrorMsg();
  const bool is_full =
      detail.find("No space") != std::string::npos || detail.find("too small") != std::string::npos;
  return {is_full ? ErrorCode::kOutOfSpace : ErrorCode::kIo, "cannot write the GeoTIFF: " + detail, detail};
}

bool IsClosedWell(std::unique_ptr<GDALDataset> written) {
  CPLErrorReset();
  written.reset();
  return CPLGetLastErrorType() < CE_Failure;
}

}  // namespace skyquilt::storage
