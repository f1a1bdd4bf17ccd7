#include "storage/exports/warp_geotiff.h"

#include <cpl_error.h>
#include <cpl_string.h>
#include <fmt/core.h>
#include <gdal_priv.h>
#include <gdal_utils.h>

#include <initializer_list>
#include <memory>
#include <string>
#include <system_error>
#include <utility>

#include "core/base/try.h"
#include "storage/rasters/register_gdal.h"
#include "storage/tilesets/publish_file.h"

namespace skyquilt::storage {
namespace {

// The share of the whole that a step of it is.
struct Listener {
  Progress& progress;
  const char* message;
  double from = 0.0, to = 1.0;
};

int Forward(double fraction, const char*, void* to) {
  auto& listener = *static_cast<Listener*>(to);
  listener.progress.Report(listener.from + fraction * (listener.to - listener.from), listener.message);
  return listener.progress.IsCancelled() ? FALSE : TRUE;
}

// Gone at the end of the scope, where it is still there.
class TemporaryTiff {
 public:
  TemporaryTiff(std::filesystem::path path, const char* ending) : path_(std::move(path)) { path_ += ending; }
  ~TemporaryTiff() {
    std::error_code gone;  // what stays is overwritten by the next run
    std::filesystem::remove(path_, gone);
  }
  TemporaryTiff(const TemporaryTiff&) = delete;
  TemporaryTiff& operator=(const TemporaryTiff&) = delete;
  const char* c_str() const { return path_.c_str(); }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

void AddWords(CPLStringList& words, std::initializer_list<std::string> more) {
  for (const std::string& word : more) words.AddString(word.c_str());
}

Error LastError(const Progress& progress) {
  if (progress.IsCancelled()) return {ErrorCode::kCancelled, "the job was cancelled", ""};
  const std::string detail = CPLGetLastErrorMsg();
  const bool is_full =
      detail.find("No space") != std::string::npos || detail.find("too small") != std::string::npos;
  return {is_full ? ErrorCode::kOutOfSpace : ErrorCode::kIo, "cannot write the GeoTIFF: " + detail, detail};
}

// Closing writes what is left; an error there is an error of the file.
bool IsClosedWell(std::unique_ptr<GDALDataset> written) {
  CPLErrorReset();
  written.reset();
  return CPLGetLastErrorType() < CE_Failure;
}

// In the other system, without loss.
Result<void> Warp(GDALDataset& source, const char* path, const WarpOptions& options,
                  const std::string& threads, Progress& progress) {
  // Metres to the micrometre, degrees to a tenth of one.
  const int digits = options.pixel_x < 1e-3 ? 12 : 6;
  CPLStringList words;
  AddWords(words, {"-t_srs",
                   fmt::format("EPSG:{}", options.epsg),
                   "-tr",
                   fmt::format("{:.{}f}", options.pixel_x, digits),
                   fmt::format("{:.{}f}", options.pixel_y, digits),
                   "-tap",
                   "-r",
                   options.is_coarser ? "average" : "cubic",
                   "-wm",
                   "128",
                   "-multi",
                   "-wo",
                   "NUM_THREADS=" + threads,
                   "-of",
                   "GTiff",
                   "-co",
                   "TILED=YES",
                   "-co",
                   "COMPRESS=DEFLATE",
                   "-co",
                   "ZLEVEL=1",
                   "-co",
                   "SPARSE_OK=TRUE",
                   "-co",
                   "NUM_THREADS=" + threads,
                   "-co",
                   "BIGTIFF=IF_SAFER"});
  if (source.GetRasterCount() == 3) AddWords(words, {"-dstalpha"});
  if (options.bounds) {
    const auto& [west, south, east, north] = *options.bounds;
    AddWords(words, {"-te", fmt::format("{:.12f}", west), fmt::format("{:.12f}", south),
                     fmt::format("{:.12f}", east), fmt::format("{:.12f}", north), "-te_srs", "EPSG:4326"});
  }
  const std::unique_ptr<GDALWarpAppOptions, void (*)(GDALWarpAppOptions*)> warp(
      GDALWarpAppOptionsNew(words.List(), nullptr), GDALWarpAppOptionsFree);
  if (!warp) return LastError(progress);
  Listener listener{progress, options.message, 0.0, 0.8};
  GDALWarpAppOptionsSetProgress(warp.get(), Forward, &listener);
  GDALDatasetH from = GDALDataset::ToHandle(&source);
  std::unique_ptr<GDALDataset> written(
      GDALDataset::FromHandle(GDALWarp(path, nullptr, 1, &from, warp.get(), nullptr)));
  if (!written || !IsClosedWell(std::move(written))) return LastError(progress);
  return {};
}

// Tiled, with overviews, as JPEG with a mask.
Result<void> MakeCog(const char* from, const char* path, const WarpOptions& options,
                     const std::string& threads, Progress& progress) {
  const std::unique_ptr<GDALDataset> source(GDALDataset::Open(from, GDAL_OF_RASTER | GDAL_OF_READONLY));
  if (!source) return LastError(progress);
  CPLStringList words;
  AddWords(words, {"-of", "COG", "-co", "COMPRESS=JPEG", "-co",
                   fmt::format("QUALITY={}", options.jpeg_quality), "-co", "OVERVIEW_RESAMPLING=AVERAGE",
                   "-co", "BIGTIFF=IF_SAFER", "-co", "NUM_THREADS=" + threads});
  const std::unique_ptr<GDALTranslateOptions, void (*)(GDALTranslateOptions*)> translate(
      GDALTranslateOptionsNew(words.List(), nullptr), GDALTranslateOptionsFree);
  if (!translate) return LastError(progress);
  Listener listener{progress, options.message, 0.8, 1.0};
  GDALTranslateOptionsSetProgress(translate.get(), Forward, &listener);
  std::unique_ptr<GDALDataset> written(GDALDataset::FromHandle(
      GDALTranslate(path, GDALDataset::ToHandle(source.get()), translate.get(), nullptr)));
  if (!written || !IsClosedWell(std::move(written))) return LastError(progress);
  return {};
}

}  // namespace

Result<void> WarpGeotiff(const std::filesystem::path& cog, const std::filesystem::path& path,
                         const WarpOptions& options, Progress& progress) {
  RegisterGdalOnce();
  CPLErrorReset();
  const std::unique_ptr<GDALDataset> source(
      GDALDataset::Open(cog.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY));
  if (!source) return LastError(progress);
  const std::string threads = options.threads > 0 ? std::to_string(options.threads) : "ALL_CPUS";
  // In two steps: a COG is written in several passes over its source, each of which would warp again.
  const TemporaryTiff warped(path, ".warped.tmp"), made(path, ".tmp");
  SKYQUILT_TRY(Warp(*source, warped.c_str(), options, threads, progress));
  SKYQUILT_TRY(MakeCog(warped.c_str(), made.c_str(), options, threads, progress));
  return PublishFile(made.path(), path);
}

}  // namespace skyquilt::storage
