#include "api/grids/map_grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/geo/web_mercator.h"
#include "storage/exports/warped/warp_tiles.h"

namespace skyquilt::api {
namespace {

constexpr const char* kDegreesName = "WorldCRS84Quad";
constexpr const char* kSetUri = "http://www.opengis.net/def/tilematrixset/OGC/1.0/";
constexpr int kUtmNorthCode = 32600;
constexpr double kMetresPerPixelOfScale = 0.00028;
constexpr double kMetresPerDegree = geo::kWgs84SemiMajorM * geo::kPi / 180.0;

// From the equator to a pole along a meridian of WGS84. The registered grids of UTM begin two of these north
// of the equator and one west of the zone's middle, without the zone's scale of 0.9996.
constexpr double kMeridianQuarterM = 10001965.72931276;
constexpr double kFalseEastingM = 500000.0;

// The most that a cell of a unit's side stretches in merc, at a place.
std::optional<double> MercPerUnit(const MapCrs& crs, const Eigen::Vector2d& place, double step) {
  const auto merc_at = [&](const Eigen::Vector2d& at) -> std::optional<Eigen::Vector2d> {
    const std::optional<geo::LatLon> position = crs.LatLonOf(at);
    if (!position || std::abs(position->lat_deg) > 89.0) return std::nullopt;
    return geo::MercFromLatLon(*position);
  };
  const auto here = merc_at(place), east = merc_at(place + Eigen::Vector2d(step, 0.0)),
             north = merc_at(place + Eigen::Vector2d(0.0, step));
  if (!here || !east || !north) return std::nullopt;
  return std::max((*east - *here).norm(), (*north - *here).norm()) / step;
}

}  // namespace

MapGrid MapGrid::WorldCrs84() { return MapGrid(0); }

MapGrid MapGrid::Utm(int zone) {
  SKYQUILT_CHECK(zone >= 1 && zone <= kZones, "a zone that UTM does not have");
  return MapGrid(zone);
}

std::optional<MapGrid> MapGrid::Named(std::string_view name) {
  if (name == kDegreesName) return WorldCrs84();
  for (int zone = 1; zone <= kZones; ++zone) {
    if (Utm(zone).name() == name) return Utm(zone);
  }
  return std::nullopt;
}

std::string MapGrid::name() const {
  return is_in_degrees() ? kDegreesName : fmt::format("UTM{:02}WGS84Quad", zone_);
}

std::string MapGrid::title() const {
  return is_in_degrees() ? "CRS84 for the World"
                         : fmt::format("Universal Transverse Mercator Zone {:02} WGS84 Quad", zone_);
}

std::string MapGrid::uri() const { return kSetUri + name(); }

std::string MapGrid::crs_urn() const {
  return is_in_degrees() ? "urn:ogc:def:crs:OGC:1.3:CRS84"
                         : fmt::format("urn:ogc:def:crs:EPSG::{}", kUtmNorthCode + zone_);
}

const char* MapGrid::scale_set() const { return is_in_degrees() ? "GoogleCRS84Quad" : ""; }

Result<MapCrs> MapGrid::Crs() const {
  if (is_in_degrees()) return MapCrs::Crs84();
  return MapCrs::OfEpsg(kUtmNorthCode + zone_);
}

double MapGrid::CellSize(int level) const {
  const double first = is_in_degrees() ? 180.0 / kTilePx : 2.0 * kMeridianQuarterM / kTilePx;
  return std::ldexp(first, first_level() - level);
}

double MapGrid::ScaleDenominator(int level) const {
  return CellSize(level) * (is_in_degrees() ? kMetresPerDegree : 1.0) / kMetresPerPixelOfScale;
}

Eigen::Vector2d MapGrid::UpperLeft() const {
  if (is_in_degrees()) return {-180.0, 90.0};
  return {kFalseEastingM - kMeridianQuarterM, 2.0 * kMeridianQuarterM};
}

std::int64_t MapGrid::Columns(int level) const {
  return std::int64_t{is_in_degrees() ? 2 : 1} << (level - first_level());
}

std::int64_t MapGrid::Rows(int level) const {
  return std::int64_t{is_in_degrees() ? 1 : 2} << (level - first_level());
}

geo::Bounds2 MapGrid::BoundsOf(int level, std::int64_t column, std::int64_t row) const {
  const double side = CellSize(level) * kTilePx;
  const Eigen::Vector2d corner = UpperLeft();
  geo::Bounds2 bounds;
  bounds.min = {corner.x() + static_cast<double>(column) * side,
                corner.y() - static_cast<double>(row + 1) * side};
  bounds.max = {corner.x() + static_cast<double>(column + 1) * side,
                corner.y() - static_cast<double>(row) * side};
  return bounds;
}

std::vector<MapGrid> GridsOf(const storage::Revision& revision) {
  std::vector<MapGrid> grids = {MapGrid::WorldCrs84()};
  if (const Result<int> epsg = storage::UtmEpsg(revision.bounds.Middle()))
    grids.push_back(MapGrid::Utm(*epsg % 100));
  return grids;
}

std::vector<GridMatrix> MatricesOf(const MapGrid& grid, const storage::Revision& revision,
                                   int stored_size_px) {
  const Result<MapCrs> crs = grid.Crs();
  if (!crs) return {};
  const std::optional<geo::Bounds2> box = BoxIn(*crs, revision.bounds);
  const std::optional<Eigen::Vector2d> middle = crs->PlaceOf(revision.bounds.Middle());
  if (!box || !middle) return {};
  const std::optional<double> merc_per_unit = MercPerUnit(*crs, *middle, grid.is_in_degrees() ? 1e-5 : 1.0);
  if (!merc_per_unit) return {};
  // The first level whose cells are no coarser than the pixels of a zoom.
  const auto level_of = [&](int zoom) {
    constexpr double kAsGood = 1.001;
    int level = grid.first_level();
    while (level < grid.last_level() &&
           grid.CellSize(level) * *merc_per_unit > geo::PixelSizeInMercM(zoom, stored_size_px) * kAsGood) {
      ++level;
    }
    return level;
  };
  std::vector<GridMatrix> matrices;
  for (int level = level_of(revision.min_zoom); level <= level_of(revision.max_zoom); ++level) {
    const double side = grid.CellSize(level) * MapGrid::kTilePx;
    const auto tile_at = [&](double offset, std::int64_t count) {
      return std::clamp(static_cast<std::int64_t>(std::floor(offset / side)), std::int64_t{0}, count - 1);
    };
    const Eigen::Vector2d corner = grid.UpperLeft();
    GridMatrix matrix;
    matrix.level = level;
    matrix.min_column = tile_at(box->min.x() - corner.x(), grid.Columns(level));
    matrix.max_column = tile_at(box->max.x() - corner.x(), grid.Columns(level));
    matrix.min_row = tile_at(corner.y() - box->max.y(), grid.Rows(level));
    matrix.max_row = tile_at(corner.y() - box->min.y(), grid.Rows(level));
    // Across the antimeridian columns lie at both ends, and one span has to hold them.
    if (grid.is_in_degrees() && revision.bounds.east_deg > 180.0) {
      matrix.min_column = 0;
      matrix.max_column = grid.Columns(level) - 1;
    }
    matrices.push_back(matrix);
  }
  return matrices;
}

}  // namespace skyquilt::api
