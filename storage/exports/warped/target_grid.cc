#include "storage/exports/warped/target_grid.h"

#include <cmath>
#include <limits>

#include "core/base/try.h"
#include "core/flight/remarks/because.h"
#include "core/geo/web_mercator.h"
#include "storage/rasters/gdal_steps.h"

namespace skyquilt::storage {
namespace {

constexpr int kWgs84 = 4326, kWebMercator = 3857;

// The edges bend in the other system, so that four corners do not tell.
Result<geo::Bounds2> BoundsIn(OGRCoordinateTransformation& target_from_wgs84, const geo::LatLonBounds& bounds,
                              int epsg) {
  constexpr int kPointsOfEdge = 21;
  constexpr double kBesideDateLineDeg = 180.0 - 1e-9;
  const double middle_deg = bounds.Middle().lat_deg;
  // Where coordinates begin anew at the date line: by so much.
  double around_x[2] = {kBesideDateLineDeg, -kBesideDateLineDeg}, around_y[2] = {middle_deg, middle_deg};
  const bool is_beyond = bounds.east_deg > 180.0;
  const double around =
      is_beyond && target_from_wgs84.Transform(2, around_x, around_y) ? around_x[0] - around_x[1] : 0.0;
  geo::Bounds2 box;
  const auto include = [&](double lon_deg, double lat_deg) {
    double x = std::remainder(lon_deg, 360.0), y = lat_deg;
    if (!target_from_wgs84.Transform(1, &x, &y)) return false;
    box.Include(Eigen::Vector2d(lon_deg > 180.0 ? x + around : x, y));
    return true;
  };
  for (int i = 0; i <= kPointsOfEdge; ++i) {
    const double share = static_cast<double>(i) / kPointsOfEdge;
    const double lon = bounds.west_deg + share * (bounds.east_deg - bounds.west_deg);
    const double lat = bounds.south_deg + share * (bounds.north_deg - bounds.south_deg);
    if (!include(lon, bounds.south_deg) || !include(lon, bounds.north_deg) ||
        !include(bounds.west_deg, lat) || !include(bounds.east_deg, lat))
      return TargetGrid::Unreachable(epsg);
  }
  return box;
}

}  // namespace

Error TargetGrid::Unreachable(int epsg) {
  return flight::Because(ErrorCode::kUnprocessable,
                         {flight::RemarkCode::kExportSystemUnreachable, {{"epsg", epsg}}});
}

Result<std::unique_ptr<TargetGrid>> TargetGrid::Cover(const geo::LatLonBounds& bounds, int epsg,
                                                      double pixel_x, double pixel_y) {
  const QuietGdal quiet;
  std::unique_ptr<TargetGrid> grid(new TargetGrid);
  OGRSpatialReference wgs84, merc;
  for (auto& [system, code] :
       {std::pair<OGRSpatialReference&, int>(wgs84, kWgs84), {merc, kWebMercator}, {grid->system_, epsg}}) {
    if (system.importFromEPSG(code) != OGRERR_NONE) return TargetGrid::Unreachable(epsg);
    system.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  }
  const std::unique_ptr<OGRCoordinateTransformation> target_from_wgs84(
      OGRCreateCoordinateTransformation(&wgs84, &grid->system_));
  grid->merc_from_target_.reset(OGRCreateCoordinateTransformation(&grid->system_, &merc));
  if (!target_from_wgs84 || !grid->merc_from_target_) return TargetGrid::Unreachable(epsg);
  SKYQUILT_TRY_ASSIGN(const geo::Bounds2 box, BoundsIn(*target_from_wgs84, bounds, epsg));
  const double columns = std::ceil(box.max.x() / pixel_x) - std::floor(box.min.x() / pixel_x);
  const double rows = std::ceil(box.max.y() / pixel_y) - std::floor(box.min.y() / pixel_y);
  constexpr double kMaxPixels = 1e12;  // four million blocks
  constexpr int kMaxCode = 0xffff;     // of a GeoTIFF
  if (!(columns > 0.0 && rows > 0.0 && columns * rows < kMaxPixels) || epsg > kMaxCode)
    return TargetGrid::Unreachable(epsg);
  grid->name_ = grid->system_.GetName() != nullptr ? grid->system_.GetName() : "";
  grid->epsg_ = epsg;
  grid->west_ = std::floor(box.min.x() / pixel_x) * pixel_x;
  grid->north_ = std::ceil(box.max.y() / pixel_y) * pixel_y;
  grid->pixel_x_ = pixel_x;
  grid->pixel_y_ = pixel_y;
  grid->width_px_ = static_cast<std::int64_t>(columns);
  grid->height_px_ = static_cast<std::int64_t>(rows);
  grid->middle_in_merc_m_ =
      geo::MercFromLatLon({bounds.Middle().lat_deg, (bounds.west_deg + bounds.east_deg) / 2.0}).x();
  const std::int64_t middle_x = grid->width_px_ / 2, middle_y = grid->height_px_ / 2;
  const std::vector<Eigen::Vector2d> corners = grid->CornersInMerc(middle_x, middle_y, 1, 2, 2);
  const Eigen::Vector2d along_x = corners[1] - corners[0], along_y = corners[2] - corners[0];
  grid->pixel_in_merc_m_ = std::sqrt(std::abs(along_x.x() * along_y.y() - along_x.y() * along_y.x()));
  if (!(grid->pixel_in_merc_m_ > 0.0)) return TargetGrid::Unreachable(epsg);
  return grid;
}

TiffPlace TargetGrid::place() const {
  const bool is_geographic = system_.IsGeographic() != 0;
  constexpr double kRadInDegree = 0.017453292519943295;
  const bool is_in_degrees = is_geographic && std::abs(system_.GetAngularUnits() / kRadInDegree - 1.0) < 1e-6;
  return {epsg_, is_geographic, is_in_degrees, name_, west_, north_, pixel_x_, pixel_y_};
}

std::vector<Eigen::Vector2d> TargetGrid::CornersInMerc(std::int64_t left_px, std::int64_t top_px, int step_px,
                                                       int columns, int rows) const {
  const auto count = static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  std::vector<double> x, y;
  x.reserve(count);
  y.reserve(count);
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      x.push_back(west_ + static_cast<double>(left_px + std::int64_t{column} * step_px) * pixel_x_);
      y.push_back(north_ - static_cast<double>(top_px + std::int64_t{row} * step_px) * pixel_y_);
    }
  }
  std::vector<int> is_on_earth(count, FALSE);
  {
    const std::lock_guard lock(mutex_);
    const QuietGdal quiet;
    merc_from_target_->Transform(static_cast<int>(count), x.data(), y.data(), nullptr, is_on_earth.data());
  }
  std::vector<Eigen::Vector2d> corners;
  corners.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double off_m = std::remainder(x[i] - middle_in_merc_m_, 2.0 * geo::kMercHalfWidthM);
    corners.push_back(is_on_earth[i] != FALSE
                          ? Eigen::Vector2d(middle_in_merc_m_ + off_m, y[i])
                          : Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN()));
  }
  return corners;
}

}  // namespace skyquilt::storage
