#include "storage/rasters/gdal_steps.h"

#include <cpl_conv.h>
#include <gdal_priv.h>
#include <gdal_utils.h>
#include <ogr_spatialref.h>

#include <cstdint>
#include <mutex>
#include <utility>

#include "core/base/check.h"

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

int ForwardGdalProgress(double fraction, const char*, void* step) {
  auto& told = *static_cast<GdalStep*>(step);
  told.progress.Report(told.from + fraction * (told.to - told.from), told.message);
  return told.progress.IsCancelled() ? FALSE : TRUE;
}

Error LastGdalError(const Progress& progress) {
  if (progress.IsCancelled()) return {ErrorCode::kCancelled, "the job was cancelled", ""};
  const std::string detail = CPLGetLastErrorMsg();
  const bool is_full =
      detail.find("No space") != std::string::npos || detail.find("too small") != std::string::npos;
  return {is_full ? ErrorCode::kOutOfSpace : ErrorCode::kIo, "cannot write the GeoTIFF: " + detail, detail};
}

Result<std::unique_ptr<GDALDataset>> CreateMercFloats(const std::filesystem::path& path, const MercGrid& grid,
                                                      int bands, const Progress& progress) {
  RegisterGdalOnce();
  CPLErrorReset();
  GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GTiff");
  SKYQUILT_CHECK(driver != nullptr, "GDAL writes GeoTIFF");
  CPLStringList options;
  AddGdalWords(options, {"TILED=YES", "BLOCKXSIZE=512", "BLOCKYSIZE=512", "INTERLEAVE=BAND", "COMPRESS=ZSTD",
                         "ZSTD_LEVEL=1", "PREDICTOR=3", "SPARSE_OK=TRUE", "BIGTIFF=IF_SAFER"});
  std::unique_ptr<GDALDataset> made(
      driver->Create(path.c_str(), grid.width_px, grid.height_px, bands, GDT_Float32, options.List()));
  if (!made) return LastGdalError(progress);
  OGRSpatialReference mercator;
  constexpr int kWebMercator = 3857;
  mercator.importFromEPSG(kWebMercator);
  double transform[6] = {grid.west_m, grid.pixel_width_m, 0.0, grid.north_m, 0.0, -grid.pixel_height_m};
  if (made->SetSpatialRef(&mercator) != CE_None || made->SetGeoTransform(transform) != CE_None)
    return LastGdalError(progress);
  return made;
}

bool IsClosedWell(std::unique_ptr<GDALDataset> written) {
  CPLErrorReset();
  written.reset();
  return CPLGetLastErrorType() < CE_Failure;
}

void AddGdalWords(CPLStringList& words, std::initializer_list<std::string> more) {
  for (const std::string& word : more) words.AddString(word.c_str());
}

std::string GdalThreads(int threads) {
  return "NUM_THREADS=" + (threads > 0 ? std::to_string(threads) : "ALL_CPUS");
}

bool TranslateRaster(GDALDataset& source, const char* path, CPLStringList words, GdalStep* step) {
  const std::unique_ptr<GDALTranslateOptions, void (*)(GDALTranslateOptions*)> translate(
      GDALTranslateOptionsNew(words.List(), nullptr), GDALTranslateOptionsFree);
  if (!translate) return false;
  if (step != nullptr) GDALTranslateOptionsSetProgress(translate.get(), ForwardGdalProgress, step);
  std::unique_ptr<GDALDataset> written(
      GDALDataset::FromHandle(GDALTranslate(path, GDALDataset::ToHandle(&source), translate.get(), nullptr)));
  return written && IsClosedWell(std::move(written));
}

}  // namespace skyquilt::storage
