#include "storage/exports/utm_writer.h"

#include <cpl_error.h>
#include <cpl_string.h>
#include <fmt/core.h>
#include <gdal_priv.h>
#include <gdal_utils.h>

#include <cmath>
#include <cstdint>
#include <memory>
#include <string>

#include "core/base/try.h"
#include "storage/rasters/register_gdal.h"
#include "storage/tilesets/publish_file.h"

namespace skyquilt::storage {
namespace {

int Forward(double fraction, const char*, void* to) {
  auto& progress = *static_cast<Progress*>(to);
  progress.Report(fraction, "writing the UTM GeoTIFF");
  return progress.IsCancelled() ? FALSE : TRUE;
}

Error LastError(const Progress& progress) {
  if (progress.IsCancelled()) return {ErrorCode::kCancelled, "the job was cancelled", ""};
  const std::string detail = CPLGetLastErrorMsg();
  const bool is_full =
      detail.find("No space") != std::string::npos || detail.find("too small") != std::string::npos;
  return {is_full ? ErrorCode::kOutOfSpace : ErrorCode::kIo, "cannot write the UTM GeoTIFF: " + detail,
          detail};
}

}  // namespace

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
  RegisterGdalOnce();
  CPLErrorReset();
  const std::unique_ptr<GDALDataset> source(
      GDALDataset::Open(cog.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY));
  if (!source) return LastError(progress);
  std::filesystem::path temporary = path;
  temporary += ".tmp";
  CPLStringList words;
  const auto add = [&](std::initializer_list<std::string> more) {
    for (const std::string& word : more) words.AddString(word.c_str());
  };
  const std::string pixel = fmt::format("{:.6f}", options.pixel_m);
  const std::string threads = options.threads > 0 ? std::to_string(options.threads) : "ALL_CPUS";
  add({"-t_srs",
       fmt::format("EPSG:{}", epsg),
       "-tr",
       pixel,
       pixel,
       "-tap",
       "-r",
       "cubic",
       "-wm",
       "128",
       "-multi",
       "-wo",
       "NUM_THREADS=" + threads,
       "-of",
       "COG",
       "-co",
       "COMPRESS=JPEG",
       "-co",
       fmt::format("QUALITY={}", options.jpeg_quality),
       "-co",
       "OVERVIEW_RESAMPLING=AVERAGE",
       "-co",
       "BIGTIFF=IF_SAFER",
       "-co",
       "NUM_THREADS=" + threads});
  if (source->GetRasterCount() == 3) add({"-dstalpha"});
  const std::unique_ptr<GDALWarpAppOptions, void (*)(GDALWarpAppOptions*)> warp(
      GDALWarpAppOptionsNew(words.List(), nullptr), GDALWarpAppOptionsFree);
  if (!warp) return LastError(progress);
  GDALWarpAppOptionsSetProgress(warp.get(), Forward, &progress);
  GDALDatasetH from = GDALDataset::ToHandle(source.get());
  std::unique_ptr<GDALDataset> written(
      GDALDataset::FromHandle(GDALWarp(temporary.c_str(), nullptr, 1, &from, warp.get(), nullptr)));
  const bool is_made = written != nullptr;
  const Error failure = is_made ? Error{} : LastError(progress);
  if (is_made) {
    // Closing writes what is left; an error there is an error of the file.
    CPLErrorReset();
    written.reset();
    if (CPLGetLastErrorType() < CE_Failure) return PublishFile(temporary, path);
  }
  const Error error = is_made ? LastError(progress) : failure;
  std::error_code gone;  // a temporary file that will not go is overwritten by the next run
  std::filesystem::remove(temporary, gone);
  return error;
}

}  // namespace skyquilt::storage
