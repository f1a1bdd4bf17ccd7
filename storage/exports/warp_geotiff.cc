#include "storage/exports/warp_geotiff.h"

#include <cpl_error.h>
#include <fmt/core.h>
#include <gdal_priv.h>
#include <gdal_utils.h>
#include <ogr_spatialref.h>

#include <memory>
#include <string>
#include <utility>

#include "core/base/try.h"
#include "storage/files/publish_file.h"
#include "storage/rasters/gdal_steps.h"

namespace skyquilt::storage {
namespace {

const char* ResamplingOf(const WarpOptions& options) {
  switch (options.pixels) {
    case WarpedPixels::kHeights:
      return "bilinear";
    case WarpedPixels::kCounts:
      return "near";
    case WarpedPixels::kValues:
      break;
  }
  return options.target.is_coarser ? "average" : "bilinear";
}

// What covers the bounds: their edges bend in the other system, so that two corners do not tell.
Result<geo::Bounds2> BoundsInTarget(const geo::LatLonBounds& bounds, int epsg, const Progress& progress) {
  constexpr int kWgs84 = 4326, kPointsOfEdge = 21;
  OGRSpatialReference from, to;
  for (auto& [system, code] : {std::pair<OGRSpatialReference&, int>(from, kWgs84), {to, epsg}}) {
    if (system.importFromEPSG(code) != OGRERR_NONE) return LastGdalError(progress);
    system.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  }
  const std::unique_ptr<OGRCoordinateTransformation> transformation(
      OGRCreateCoordinateTransformation(&from, &to));
  geo::Bounds2 box;
  if (!transformation || transformation->TransformBounds(bounds.west_deg, bounds.south_deg, bounds.east_deg,
                                                         bounds.north_deg, &box.min.x(), &box.min.y(),
                                                         &box.max.x(), &box.max.y(), kPointsOfEdge) == 0)
    return LastGdalError(progress);
  return box;
}

// In the other system, without loss.
Result<void> Warp(GDALDataset& source, const char* path, const WarpOptions& options,
                  const std::string& threads, Progress& progress) {
  // Metres to the micrometre, degrees to a tenth of one.
  const int digits = options.target.pixel_x < 1e-3 ? 12 : 6;
  CPLStringList words;
  AddGdalWords(words, {"-t_srs", fmt::format("EPSG:{}", options.target.epsg), "-tr",
                       fmt::format("{:.{}f}", options.target.pixel_x, digits),
                       fmt::format("{:.{}f}", options.target.pixel_y, digits), "-tap"});
  AddGdalWords(words, {"-r", ResamplingOf(options), "-wm", "128", "-multi", "-wo", threads, "-of", "GTiff"});
  AddGdalWords(words, {"-co", "TILED=YES", "-co", "COMPRESS=DEFLATE", "-co", "ZLEVEL=1"});
  AddGdalWords(words, {"-co", "SPARSE_OK=TRUE", "-co", threads, "-co", "BIGTIFF=IF_SAFER"});
  if (options.bounds) {
    SKYQUILT_TRY_ASSIGN(const geo::Bounds2 box,
                        BoundsInTarget(*options.bounds, options.target.epsg, progress));
    AddGdalWords(words, {"-te", fmt::format("{:.9f}", box.min.x()), fmt::format("{:.9f}", box.min.y()),
                         fmt::format("{:.9f}", box.max.x()), fmt::format("{:.9f}", box.max.y())});
  }
  const std::unique_ptr<GDALWarpAppOptions, void (*)(GDALWarpAppOptions*)> warp(
      GDALWarpAppOptionsNew(words.List(), nullptr), GDALWarpAppOptionsFree);
  if (!warp) return LastGdalError(progress);
  GdalStep step{progress, options.message, 0.0, 0.8};
  GDALWarpAppOptionsSetProgress(warp.get(), ForwardGdalProgress, &step);
  GDALDatasetH from = GDALDataset::ToHandle(&source);
  std::unique_ptr<GDALDataset> written(
      GDALDataset::FromHandle(GDALWarp(path, nullptr, 1, &from, warp.get(), nullptr)));
  if (!written) return LastGdalError(progress);
  if (options.pixels == WarpedPixels::kHeights) written->GetRasterBand(1)->SetUnitType("m");
  if (!IsClosedWell(std::move(written))) return LastGdalError(progress);
  return {};
}

// Tiled, with overviews.
Result<void> MakeCog(const char* from, const char* path, const WarpOptions& options,
                     const std::string& threads, double done, Progress& progress) {
  const std::unique_ptr<GDALDataset> source(GDALDataset::Open(from, GDAL_OF_RASTER | GDAL_OF_READONLY));
  if (!source) return LastGdalError(progress);
  CPLStringList words;
  AddGdalWords(words, {"-of", "COG", "-co", "BIGTIFF=IF_SAFER", "-co", threads});
  AddGdalWords(words, {"-co", "COMPRESS=DEFLATE", "-co", "LEVEL=6", "-co", "PREDICTOR=YES"});
  AddGdalWords(words, {"-co", options.pixels == WarpedPixels::kCounts ? "OVERVIEW_RESAMPLING=NEAREST"
                                                                      : "OVERVIEW_RESAMPLING=AVERAGE"});
  if (options.window) {
    const auto& [low, high] = *options.window;
    AddGdalWords(words, {"-projwin", fmt::format("{:.6f}", low.x()), fmt::format("{:.6f}", high.y()),
                         fmt::format("{:.6f}", high.x()), fmt::format("{:.6f}", low.y())});
  }
  GdalStep step{progress, options.message, done, 1.0};
  if (!TranslateRaster(*source, path, words, &step)) return LastGdalError(progress);
  return {};
}

}  // namespace

Result<void> WarpGeotiff(const std::filesystem::path& geotiff, const std::filesystem::path& path,
                         const WarpOptions& options, Progress& progress) {
  RegisterGdalOnce();
  CPLErrorReset();
  const std::unique_ptr<GDALDataset> source(
      GDALDataset::Open(geotiff.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY));
  if (!source) return LastGdalError(progress);
  const std::string threads = GdalThreads(options.threads);
  const TemporaryFile warped(path, ".warped.tmp"), made(path, ".tmp");
  if (options.window) {
    SKYQUILT_TRY(MakeCog(geotiff.c_str(), made.c_str(), options, threads, 0.0, progress));
    return PublishFile(made.path(), path);
  }
  // In two steps: a COG is written in several passes over its source, each of which would warp again.
  constexpr double kShareOfWarp = 0.8;
  SKYQUILT_TRY(Warp(*source, warped.c_str(), options, threads, progress));
  SKYQUILT_TRY(MakeCog(warped.c_str(), made.c_str(), options, threads, kShareOfWarp, progress));
  return PublishFile(made.path(), path);
}

}  // namespace skyquilt::storage
