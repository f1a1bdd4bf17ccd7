#include "storage/cog_writer.h"

#include <cpl_error.h>
#include <cpl_string.h>
#include <gdal_priv.h>

#include <memory>
#include <string>

#include "storage/gdal_guard.h"
#include "storage/publish_file.h"

namespace skyquilt::storage {
namespace {

int Forward(double fraction, const char*, void* to) {
  auto& progress = *static_cast<Progress*>(to);
  progress.Report(fraction, "writing GeoTIFF");
  return progress.IsCancelled() ? FALSE : TRUE;
}

Error LastError(const Progress& progress) {
  if (progress.IsCancelled()) return {ErrorCode::kCancelled, "the job was cancelled", ""};
  const std::string detail = CPLGetLastErrorMsg();
  const bool is_full = detail.find("No space") != std::string::npos || detail.find("too small") != std::string::npos;
  return {is_full ? ErrorCode::kOutOfSpace : ErrorCode::kIo, "cannot write the GeoTIFF: " + detail, detail};
}

}  // namespace

Result<void> WriteCog(const std::filesystem::path& mbtiles, const std::filesystem::path& path,
                      const CogOptions& options, Progress& progress) {
  RegisterGdalOnce();
  CPLErrorReset();
  const CPLStringList open_options(
      CSLSetNameValue(CSLSetNameValue(nullptr, "ZOOM_LEVEL", std::to_string(options.max_zoom).c_str()), "BAND_COUNT", "4"));
  const char* const drivers[] = {"MBTiles", nullptr};
  const std::unique_ptr<GDALDataset> source(
      GDALDataset::Open(mbtiles.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY, drivers, open_options.List()));
  if (!source) return LastError(progress);
  std::filesystem::path temporary = path;
  temporary += ".tmp";
  CPLStringList create;
  create.SetNameValue("COMPRESS", "JPEG");
  create.SetNameValue("QUALITY", std::to_string(options.jpeg_quality).c_str());
  create.SetNameValue("TILING_SCHEME", "GoogleMapsCompatible");
  create.SetNameValue("ZOOM_LEVEL_STRATEGY", "AUTO");
  create.SetNameValue("RESAMPLING", "NEAREST");  // the grids coincide: pixels are copied, not resampled
  create.SetNameValue("OVERVIEW_RESAMPLING", "AVERAGE");
  create.SetNameValue("ADD_ALPHA", "NO");
  create.SetNameValue("BIGTIFF", "IF_SAFER");
  create.SetNameValue("NUM_THREADS", options.threads > 0 ? std::to_string(options.threads).c_str() : "ALL_CPUS");
  GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("COG");
  const std::unique_ptr<GDALDataset> written(
      driver->CreateCopy(temporary.c_str(), source.get(), FALSE, create.List(), Forward, &progress));
  if (!written) {
    const Error error = LastError(progress);
    std::error_code gone;
    std::filesystem::remove(temporary, gone);
    return error;
  }
  // Closing writes what is left; an error there is an error of the file.
  CPLErrorReset();
  const_cast<std::unique_ptr<GDALDataset>&>(written).reset();
  if (CPLGetLastErrorType() >= CE_Failure) return LastError(progress);
  return PublishFile(temporary, path);
}

}  // namespace skyquilt::storage
