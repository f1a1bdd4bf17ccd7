#include "storage/rasters/map_raster.h"

#include <cpl_error.h>
#include <fmt/core.h>
#include <gdal_alg.h>
#include <gdal_priv.h>
#include <gdal_utils.h>
#include <ogr_spatialref.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <map>
#include <optional>
#include <utility>

#include "core/base/try.h"
#include "core/flight/remarks/because.h"
#include "core/geo/tile_id.h"
#include "core/geo/web_mercator.h"
#include "storage/rasters/gdal_steps.h"

namespace skyquilt::storage {
namespace {

using DatasetPointer = std::unique_ptr<GDALDataset>;

constexpr int kMaxMapZoom = 22;  // the finest that GDAL and QGIS open
constexpr int kMaxTileSizePx = 1024;
// A pixel that is a hair larger than the tiles' is theirs.
constexpr double kPixelTolerance = 1.01;

Error RasterError(ErrorCode code, const std::string& name, flight::RemarkCode why,
                  std::map<std::string, flight::RemarkValue> values = {}) {
  values.emplace("file", name);
  return flight::Because(code, {why, std::move(values)}, CPLGetLastErrorMsg());
}

Result<void> CheckPixels(GDALDataset& raster, const std::string& name) {
  const int bands = raster.GetRasterCount();
  if (bands < 1)
    return RasterError(ErrorCode::kUnsupportedFormat, name, flight::RemarkCode::kImportNoPicture);
  for (int band = 1; band <= std::min(bands, 4); ++band) {
    const GDALDataType type = raster.GetRasterBand(band)->GetRasterDataType();
    if (type == GDT_Byte) continue;
    return RasterError(ErrorCode::kUnsupportedFormat, name, flight::RemarkCode::kImportPixelType,
                       {{"type", GDALGetDataTypeName(type)}});
  }
  return {};
}

// Whether its outline crosses 180 degrees of longitude, where the web map's tiles end: GDAL brings one side
// of it there, or none. What goes round the Earth or holds a pole has pixels on all columns.
bool CrossesAntimeridian(GDALDataset& raster) {
  OGRSpatialReference own(*raster.GetSpatialRef()), wgs84;
  wgs84.importFromEPSG(4326);
  for (OGRSpatialReference* system : {&own, &wgs84})
    system->SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  const std::unique_ptr<OGRCoordinateTransformation> to_wgs84(
      OGRCreateCoordinateTransformation(&own, &wgs84));
  std::array<double, 6> transform{};
  if (!to_wgs84 || raster.GetGeoTransform(transform.data()) != CE_None) return false;
  constexpr int kStepsOfEdge = 32;
  constexpr double kInset = 1e-6;  // an edge that lies on 180 degrees does not cross them
  constexpr double kRoundTheEarthDeg = 350.0;
  constexpr std::array<std::array<double, 2>, 5> kCorners = {
      {{0.0, 0.0}, {1.0, 0.0}, {1.0, 1.0}, {0.0, 1.0}, {0.0, 0.0}}};
  std::optional<double> begin_deg;
  double lon_deg = 0.0, west_deg = 0.0, east_deg = 0.0;
  for (std::size_t edge = 0; edge + 1 < kCorners.size(); ++edge) {
    for (int step = 0; step <= kStepsOfEdge; ++step) {
      const auto along = [&](std::size_t axis, int size_px) {
        const double from = kCorners[edge][axis], to = kCorners[edge + 1][axis];
        return size_px * (kInset + (1.0 - 2.0 * kInset) * (from + (to - from) * step / kStepsOfEdge));
      };
      const double column = along(0, raster.GetRasterXSize()), row = along(1, raster.GetRasterYSize());
      double x = transform[0] + column * transform[1] + row * transform[2];
      double y = transform[3] + column * transform[4] + row * transform[5];
      if (!to_wgs84->Transform(1, &x, &y) || !std::isfinite(x)) return false;
      if (!begin_deg) begin_deg = lon_deg = west_deg = east_deg = std::remainder(x, 360.0);
      lon_deg += std::remainder(x - lon_deg, 360.0);
      west_deg = std::min(west_deg, lon_deg);
      east_deg = std::max(east_deg, lon_deg);
    }
  }
  const bool holds_pole = std::abs(lon_deg - *begin_deg) > 180.0;
  return !holds_pole && east_deg - west_deg < kRoundTheEarthDeg && (east_deg > 180.0 || west_deg < -180.0);
}

Result<void> CheckPlace(GDALDataset& raster, const std::string& name) {
  std::array<double, 6> transform{};
  if (raster.GetGeoTransform(transform.data()) != CE_None)
    return RasterError(ErrorCode::kUnprocessable, name, flight::RemarkCode::kImportNotGeoreferenced);
  const OGRSpatialReference* reference = raster.GetSpatialRef();
  if (reference == nullptr || reference->IsEmpty())
    return RasterError(ErrorCode::kUnprocessable, name, flight::RemarkCode::kImportWithoutSystem);
  if (reference->IsLocal())
    return RasterError(ErrorCode::kUnprocessable, name, flight::RemarkCode::kImportLocalSystem);
  if (CrossesAntimeridian(raster))
    return RasterError(ErrorCode::kUnprocessable, name, flight::RemarkCode::kImportAcrossAntimeridian);
  return {};
}

// As red, green, blue and what says which of them are covered.
Result<DatasetPointer> AsColours(GDALDataset& raster, const std::string& name) {
  const int bands = raster.GetRasterCount();
  const auto interpretation = [&](int band) { return raster.GetRasterBand(band)->GetColorInterpretation(); };
  const bool ends_in_alpha = (bands == 2 || bands == 4) && interpretation(bands) == GCI_AlphaBand;
  CPLStringList words;
  const auto add = [&](std::initializer_list<std::string> more) { AddGdalWords(words, more); };
  add({"-of", "VRT"});
  if (bands == 1 && raster.GetRasterBand(1)->GetColorTable() != nullptr) {
    add({"-expand", "rgba"});
  } else if (bands < 3) {
    add({"-b", "1", "-b", "1", "-b", "1"});
    if (ends_in_alpha) add({"-b", "2", "-colorinterp_4", "alpha"});
    add({"-colorinterp_1", "red", "-colorinterp_2", "green", "-colorinterp_3", "blue"});
  } else {
    add({"-b", "1", "-b", "2", "-b", "3"});
    if (ends_in_alpha) add({"-b", "4", "-colorinterp_4", "alpha"});
  }
  GDALTranslateOptions* options = GDALTranslateOptionsNew(words.List(), nullptr);
  DatasetPointer made(
      GDALDataset::FromHandle(GDALTranslate("", GDALDataset::ToHandle(&raster), options, nullptr)));
  GDALTranslateOptionsFree(options);
  if (!made) return RasterError(ErrorCode::kUnsupportedFormat, name, flight::RemarkCode::kImportNoColours);
  return made;
}

struct MercExtent {
  double pixel_merc_m = 0.0;
  double west_m = 0.0, south_m = 0.0, east_m = 0.0, north_m = 0.0;  // merc
};

Result<MercExtent> ExtentOfRaster(GDALDataset& raster, const std::string& name) {
  OGRSpatialReference merc;
  merc.importFromEPSG(3857);
  char* text = nullptr;
  merc.exportToWkt(&text);
  const std::string wkt(text);
  CPLFree(text);
  void* transformer = GDALCreateGenImgProjTransformer(GDALDataset::ToHandle(&raster), nullptr, nullptr,
                                                      wkt.c_str(), FALSE, 0.0, 1);
  const Error lost = RasterError(ErrorCode::kUnprocessable, name, flight::RemarkCode::kImportElsewhere);
  if (transformer == nullptr) return lost;
  std::array<double, 6> transform{};
  std::array<double, 4> box{};
  int width = 0, height = 0;
  const CPLErr suggested =
      GDALSuggestedWarpOutput2(GDALDataset::ToHandle(&raster), GDALGenImgProjTransform, transformer,
                               transform.data(), &width, &height, box.data(), 0);
  GDALDestroyGenImgProjTransformer(transformer);
  const MercExtent extent{transform[1], box[0], std::max(box[1], -geo::kMercHalfWidthM), box[2],
                          std::min(box[3], geo::kMercHalfWidthM)};
  const bool is_sound = suggested == CE_None && std::isfinite(extent.west_m + extent.east_m) &&
                        extent.pixel_merc_m > 1e-4 && extent.west_m < extent.east_m &&
                        extent.south_m < extent.north_m && extent.west_m > -geo::kMercHalfWidthM - 1.0 &&
                        extent.east_m < geo::kMercHalfWidthM + 1.0;
  return is_sound ? Result<MercExtent>(extent) : Result<MercExtent>(lost);
}

}  // namespace

struct MapRaster::Dataset {
  std::string name;  // of the file, for errors
  // Each reads from the one before.
  DatasetPointer file, colours, warped;
};

MapRaster::MapRaster(std::unique_ptr<Dataset> dataset) : dataset_(std::move(dataset)) {}
MapRaster::~MapRaster() {
  dataset_->warped.reset();
  dataset_->colours.reset();
}

Result<std::unique_ptr<MapRaster>> MapRaster::Open(const std::filesystem::path& path,
                                                   const std::string& name) {
  std::error_code missing;
  if (!std::filesystem::is_regular_file(path, missing))
    return RasterError(ErrorCode::kNotFound, name, flight::RemarkCode::kImportNotThere);
  RegisterGdalOnce();
  const QuietGdal quiet;
  auto made = std::make_unique<Dataset>();
  made->name = name;
  constexpr std::array<const char*, 2> kDrivers = {"GTiff", nullptr};
  made->file.reset(GDALDataset::Open(path.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY, kDrivers.data()));
  if (!made->file)
    return RasterError(ErrorCode::kUnsupportedFormat, name, flight::RemarkCode::kImportNoGeotiff);
  SKYQUILT_TRY(CheckPixels(*made->file, name));
  SKYQUILT_TRY(CheckPlace(*made->file, name));
  SKYQUILT_TRY_ASSIGN(made->colours, AsColours(*made->file, name));
  SKYQUILT_TRY_ASSIGN(const MercExtent extent, ExtentOfRaster(*made->file, name));

  std::unique_ptr<MapRaster> raster(new MapRaster(std::move(made)));
  raster->bounds_ =
      geo::LatLonBoundsFromMerc({{extent.west_m, extent.south_m}, {extent.east_m, extent.north_m}});
  const double lat_deg = raster->bounds_.Middle().lat_deg;
  raster->pixel_m_ = extent.pixel_merc_m * geo::GroundMetresPerMercMetre(lat_deg);
  int zoom = geo::ZoomForGsd(raster->pixel_m_ * kPixelTolerance, lat_deg, kUsualTileSizePx);
  while (zoom > kMaxMapZoom && raster->tile_size_px_ < kMaxTileSizePx) {
    raster->tile_size_px_ *= 2;
    --zoom;
  }
  raster->zoom_ = std::min(zoom, kMaxMapZoom);
  const double tile_m = geo::TileSizeInMercM(raster->zoom_);
  const int last = (1 << raster->zoom_) - 1;
  const auto tile_at = [&](double from_corner_m) {
    return std::clamp(static_cast<int>(std::floor(from_corner_m / tile_m)), 0, last);
  };
  constexpr double kInsideM = 1e-6;  // an edge on a tile's corner does not reach into the next
  raster->first_column_ = tile_at(extent.west_m + geo::kMercHalfWidthM + kInsideM);
  raster->last_column_ = tile_at(extent.east_m + geo::kMercHalfWidthM - kInsideM);
  raster->first_row_ = tile_at(geo::kMercHalfWidthM - extent.north_m + kInsideM);
  raster->last_row_ = tile_at(geo::kMercHalfWidthM - extent.south_m - kInsideM);
  const std::int64_t tiles = std::int64_t{raster->last_column_ - raster->first_column_ + 1} *
                             (raster->last_row_ - raster->first_row_ + 1);
  if (tiles > kMaxTiles)
    return RasterError(ErrorCode::kTooLarge, name, flight::RemarkCode::kImportTooLarge,
                       {{"tiles", tiles}, {"most", kMaxTiles}});

  const double pixel_m = geo::PixelSizeInMercM(raster->zoom_, raster->tile_size_px_);
  const auto edge = [&](int tile, bool is_row) {
    return fmt::format("{:.9f}",
                       is_row ? geo::kMercHalfWidthM - tile * tile_m : tile * tile_m - geo::kMercHalfWidthM);
  };
  const auto size = [&](int first, int last_one) {
    return std::to_string(std::int64_t{last_one - first + 1} * raster->tile_size_px_);
  };
  CPLStringList words;
  AddGdalWords(words,
               {"-of", "VRT", "-t_srs", "EPSG:3857", "-te", edge(raster->first_column_, false),
                edge(raster->last_row_ + 1, true), edge(raster->last_column_ + 1, false),
                edge(raster->first_row_, true), "-ts", size(raster->first_column_, raster->last_column_),
                size(raster->first_row_, raster->last_row_), "-r",
                extent.pixel_merc_m > 1.5 * pixel_m ? "bilinear" : "cubic", "-wm", "128"});
  if (raster->dataset_->colours->GetRasterCount() == 3) words.AddString("-dstalpha");
  GDALWarpAppOptions* options = GDALWarpAppOptionsNew(words.List(), nullptr);
  GDALDatasetH from = GDALDataset::ToHandle(raster->dataset_->colours.get());
  raster->dataset_->warped.reset(GDALDataset::FromHandle(GDALWarp("", nullptr, 1, &from, options, nullptr)));
  GDALWarpAppOptionsFree(options);
  if (!raster->dataset_->warped || raster->dataset_->warped->GetRasterCount() != 4)
    return RasterError(ErrorCode::kUnprocessable, name, flight::RemarkCode::kImportNotWarped);
  return raster;
}

Result<image::RgbaImage> MapRaster::Read(int column, int row, int columns, int rows) {
  const QuietGdal quiet;
  image::RgbaImage pixels = image::RgbaImage::Transparent(columns * tile_size_px_, rows * tile_size_px_);
  GDALDataset& warped = *dataset_->warped;
  const int left = (column - first_column_) * tile_size_px_, top = (row - first_row_) * tile_size_px_;
  const int from_x = std::max(0, left), from_y = std::max(0, top);
  const int to_x = std::min(warped.GetRasterXSize(), left + pixels.width_px);
  const int to_y = std::min(warped.GetRasterYSize(), top + pixels.height_px);
  if (from_x >= to_x || from_y >= to_y) return pixels;
  const CPLErr read = warped.RasterIO(GF_Read, from_x, from_y, to_x - from_x, to_y - from_y,
                                      pixels.Pixel(from_x - left, from_y - top), to_x - from_x, to_y - from_y,
                                      GDT_Byte, 4, nullptr, 4, GSpacing{4} * pixels.width_px, 1, nullptr);
  if (read != CE_None || CPLGetLastErrorType() >= CE_Failure)
    return RasterError(ErrorCode::kCorrupt, dataset_->name, flight::RemarkCode::kImportDamaged);
  std::uint8_t* pixel = pixels.rgba.data();
  for (std::size_t i = 0; i < pixels.rgba.size(); i += 4, pixel += 4) {
    for (int c = 0; c < 3; ++c) pixel[c] = static_cast<std::uint8_t>((pixel[c] * pixel[3] + 127) / 255);
  }
  return pixels;
}

}  // namespace skyquilt::storage
