#include "storage/exports/custom/index_grid.h"

#include <gdal_priv.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "core/base/try.h"
#include "core/flight/remarks/because.h"
#include "core/geo/tile_id.h"
#include "core/geo/web_mercator.h"
#include "storage/exports/fringe_tile.h"
#include "storage/rasters/band_raster.h"
#include "storage/rasters/gdal_steps.h"

namespace skyquilt::storage {
namespace {

constexpr float kNoValue = std::numeric_limits<float>::quiet_NaN();
constexpr std::uint8_t kSolidAlpha = 128;  // as the tiles of an index have it

// Columns and rows of a zoom's tiles, the last ones included. Columns may lie beyond the antimeridian.
struct TileRange {
  std::int64_t left = 0, top = 0, right = 0, bottom = 0;
};

TileRange TilesOver(const geo::Bounds2& merc, int zoom) {
  constexpr double kOnEdge = 1e-6;  // of a tile
  const double side_m = geo::TileSizeInMercM(zoom), half_m = geo::kMercHalfWidthM;
  const auto first = [&](double metres) {
    return static_cast<std::int64_t>(std::floor(metres / side_m + kOnEdge));
  };
  const auto last = [&](double metres) {
    return static_cast<std::int64_t>(std::ceil(metres / side_m - kOnEdge)) - 1;
  };
  return {first(merc.min.x() + half_m), first(half_m - merc.max.y()), last(merc.max.x() + half_m),
          last(half_m - merc.min.y())};
}

// The pixels of these tiles.
MercGrid GridOf(const TileRange& range, const MapFacts& facts) {
  const double side_m = geo::TileSizeInMercM(facts.max_zoom);
  const double pixel_m = geo::PixelSizeInMercM(facts.max_zoom, facts.tile_size_px);
  return {static_cast<double>(range.left) * side_m - geo::kMercHalfWidthM,
          geo::kMercHalfWidthM - static_cast<double>(range.top) * side_m,
          pixel_m,
          pixel_m,
          static_cast<int>((range.right - range.left + 1) * facts.tile_size_px),
          static_cast<int>((range.bottom - range.top + 1) * facts.tile_size_px)};
}

// The values of the bands that an expression reads, a plane each, over one tile.
class Planes {
 public:
  static Result<Planes> Of(const IndexSource& source, const indices::BandExpression& expression) {
    Planes planes(source);
    if (!source.bands.empty()) {
      SKYQUILT_TRY_ASSIGN(planes.raster_, BandRaster::Open(source.bands));
    }
    SKYQUILT_TRY_ASSIGN(planes.places_,
                        PlacesOf(expression, planes.raster_ ? planes.raster_->bands() : ColourBands()));
    return planes;
  }

  TileRange Range() const {
    const MapFacts& facts = source_->facts;
    return TilesOver(raster_ ? raster_->BoundsInMerc() : geo::MercFromLatLonBounds(facts.bounds),
                     facts.max_zoom);
  }

  // False: nothing is known there.
  Result<bool> Read(std::int64_t column, std::int64_t row, std::vector<std::vector<double>>& values) {
    const auto side = static_cast<std::size_t>(source_->facts.tile_size_px);
    values.assign(places_.size(), std::vector<double>(side * side, kNoValue));
    return raster_ ? ReadRaster(column, row, values) : ReadColours(column, row, values);
  }

 private:
  explicit Planes(const IndexSource& source) : source_(&source) {}

  Result<bool> ReadRaster(std::int64_t column, std::int64_t row, std::vector<std::vector<double>>& values) {
    SKYQUILT_TRY_ASSIGN(const std::vector<std::vector<float>> read,
                        raster_->Read(GridOf({column, row, column, row}, source_->facts), places_));
    for (std::size_t i = 0; i < read.size(); ++i)
      std::copy(read[i].begin(), read[i].end(), values[i].begin());
    return true;
  }

  Result<bool> ReadColours(std::int64_t column, std::int64_t row, std::vector<std::vector<double>>& values) {
    const int zoom = source_->facts.max_zoom;
    const std::int64_t around = std::int64_t{1} << zoom;
    SKYQUILT_TRY_ASSIGN(const geo::TileId tile,
                        geo::TileId::Make(zoom, (column % around + around) % around, row));
    SKYQUILT_TRY_ASSIGN(const std::optional<FoundTile> found, source_->tiles.Find(tile));
    if (!found) return false;
    SKYQUILT_TRY_ASSIGN(const std::string bytes, source_->tiles.Load(*found));
    SKYQUILT_TRY_ASSIGN(const image::RgbaImage picture, DecodeTile(bytes, source_->facts.tile_size_px));
    for (std::size_t i = 0; i < places_.size(); ++i) {
      for (std::size_t pixel = 0; pixel < values[i].size(); ++pixel) {
        const std::uint8_t* const rgba = picture.rgba.data() + 4 * pixel;
        if (rgba[3] >= kSolidAlpha) values[i][pixel] = rgba[places_[i]] / 255.0;
      }
    }
    return true;
  }

  const IndexSource* source_;
  std::shared_ptr<BandRaster> raster_;
  std::vector<std::size_t> places_;
};

}  // namespace

Result<void> WriteIndexGrid(const IndexSource& source, const indices::BandExpression& expression,
                            const std::string& name, const Boundary* boundary,
                            const std::filesystem::path& path, Progress& progress) {
  const MapFacts& facts = source.facts;
  const int side = facts.tile_size_px;
  SKYQUILT_TRY_ASSIGN(Planes planes, Planes::Of(source, expression));
  const TileRange range = planes.Range();
  SKYQUILT_TRY_ASSIGN(std::unique_ptr<GDALDataset> made,
                      CreateMercFloats(path, GridOf(range, facts), 1, progress));
  made->GetRasterBand(1)->SetDescription(name.c_str());
  made->GetRasterBand(1)->SetNoDataValue(kNoValue);
  std::optional<geo::BoundaryOnZoom> on_zoom;
  if (boundary != nullptr) on_zoom.emplace(*boundary, facts.max_zoom, side);
  std::vector<std::uint8_t> inside;
  std::vector<std::vector<double>> values;
  std::vector<float> index(static_cast<std::size_t>(side) * static_cast<std::size_t>(side));
  bool has_value = false;
  const std::int64_t around = std::int64_t{1} << facts.max_zoom;
  for (std::int64_t row = range.top; row <= range.bottom; ++row) {
    progress.Report(static_cast<double>(row - range.top) / static_cast<double>(range.bottom - range.top + 1),
                    "values");
    if (progress.IsCancelled()) return LastGdalError(progress);
    for (std::int64_t column = range.left; column <= range.right; ++column) {
      SKYQUILT_TRY_ASSIGN(const geo::TileId tile,
                          geo::TileId::Make(facts.max_zoom, (column % around + around) % around, row));
      const geo::Cover cover = on_zoom ? on_zoom->Mask(tile, inside) : geo::Cover::kAll;
      if (cover == geo::Cover::kNone) continue;
      SKYQUILT_TRY_ASSIGN(const bool is_known, planes.Read(column, row, values));
      if (!is_known) continue;
      std::vector<const double*> rows;
      for (const std::vector<double>& plane : values) rows.push_back(plane.data());
      expression.Evaluate(rows, index);
      if (cover == geo::Cover::kPart) {
        for (std::size_t i = 0; i < index.size(); ++i) {
          if (inside[i] == 0) index[i] = kNoValue;
        }
      }
      const bool has_one =
          std::any_of(index.begin(), index.end(), [](float value) { return !std::isnan(value); });
      if (!has_one) continue;
      has_value = true;
      if (made->GetRasterBand(1)->RasterIO(GF_Write, static_cast<int>(column - range.left) * side,
                                           static_cast<int>(row - range.top) * side, side, side, index.data(),
                                           side, side, GDT_Float32, 0, 0, nullptr) != CE_None)
        return LastGdalError(progress);
    }
  }
  if (!IsClosedWell(std::move(made))) return LastGdalError(progress);
  if (has_value) return {};
  if (boundary != nullptr)
    return flight::Because(ErrorCode::kUnprocessable, flight::RemarkCode::kExportNothingWithin);
  return flight::Because(ErrorCode::kUnprocessable, flight::RemarkCode::kIndexWithoutValue);
}

}  // namespace skyquilt::storage
