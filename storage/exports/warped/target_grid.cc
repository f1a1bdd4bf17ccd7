#include "storage/exports/warped/target_grid.h"

#include <fmt/core.h>

#include <cmath>
#include <limits>

#include "core/base/try.h"
#include "core/geo/web_mercator.h"
#include "storage/rasters/quiet_gdal.h"

namespace skyquilt::storage {
namespace {

Error Unreachable(int epsg) {
  return Error{
      ErrorCode::kUnprocessable,
      fmt::format("Nothing leads from this map to EPSG:{}. Ask for another coordinate system.", epsg), ""};
}

// The edges bend in the other system, so that four corners do not tell.
Result<geo::Bounds2> BoundsIn(OGRCoordinateTransformation& target_from_wgs84, const geo::LatLonBounds& bounds,
                              int epsg) {
  constexpr int kPointsOfEdge = 21;
  geo::Bounds2 box;
  for (int i = 0; i <= kPointsOfEdge; ++i) {
    const double share = static_cast<double>(i) / kPointsOfEdge;
    const double lon = bounds.west_deg + share * (bounds.east_deg - bounds.west_deg);
    const double lat = bounds.south_deg + share * (bounds.north_deg - bounds.south_deg);
    double x[4] = {lon, lon, bounds.west_deg, bounds.east_deg};
    double y[4] = {bounds.south_deg, bounds.north_deg, lat, lat};
    if (!target_from_wgs84.Transform(4, x, y)) return Unreachable(epsg);
    for (int k = 0; k < 4; ++k) box.Include(Eigen::Vector2d(x[k], y[k]));
  }
  return box;
}

}  // namespace

Result<std::unique_ptr<TargetGrid>> TargetGrid::Cover(const geo::LatLonBounds& bounds, int epsg,
                                                      double pixel_x, double pixel_y) {
  const QuietGdal quiet;
  std::unique_ptr<TargetGrid> grid(new TargetGrid);
  constexpr int kWgs84 = 4326, kWebMercator = 3857;
  OGRSpatialReference wgs84, merc;
  for (auto& [system, code] :
       {std::pair<OGRSpatialReference&, int>(wgs84, kWgs84), {merc, kWebMercator}, {grid->system_, epsg}}) {
    if (system.importFromEPSG(code) != OGRERR_NONE) return Unreachable(epsg);
    system.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  }
  const std::unique_ptr<OGRCoordinateTransformation> target_from_wgs84(
      OGRCreateCoordinateTransformation(&wgs84, &grid->system_));
  grid->merc_from_target_.reset(OGRCreateCoordinateTransformation(&grid->system_, &merc));
  if (!target_from_wgs84 || !grid->merc_from_target_) return Unreachable(epsg);
  SKYQUILT_TRY_ASSIGN(const geo::Bounds2 box, BoundsIn(*target_from_wgs84, bounds, epsg));
  const double columns = std::ceil(box.max.x() / pixel_x) - std::floor(box.min.x() / pixel_x);
  const double rows = std::ceil(box.max.y() / pixel_y) - std::floor(box.min.y() / pixel_y);
  constexpr double kMaxSidePx = std::numeric_limits<std::int32_t>::max();
  if (!(columns > 0.0 && rows > 0.0 && columns < kMaxSidePx && rows < kMaxSidePx)) return Unreachable(epsg);
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
  SKYQUILT_TRY_ASSIGN(const auto corners, grid->CornersInMerc(middle_x, middle_y, 1, 2, 2));
  const Eigen::Vector2d along_x = corners[1] - corners[0], along_y = corners[2] - corners[0];
  grid->pixel_in_merc_m_ = std::sqrt(std::abs(along_x.x() * along_y.y() - along_x.y() * along_y.x()));
  if (!(grid->pixel_in_merc_m_ > 0.0)) return Unreachable(epsg);
  return grid;
}

TiffPlace TargetGrid::place() const {
  return {epsg_, system_.IsGeographic() != 0, name_, west_, north_, pixel_x_, pixel_y_};
}

Result<std::vector<Eigen::Vector2d>> TargetGrid::CornersInMerc(std::int64_t left_px, std::int64_t top_px,
                                                               int step_px, int columns, int rows) const {
  const auto count = static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  std::vector<double> x, y;
  x.reserve(count);
  y.reserve(count);
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      x.push_back(west_ + static_cast<double>(left_px + column * step_px) * pixel_x_);
      y.push_back(north_ - static_cast<double>(top_px + row * step_px) * pixel_y_);
    }
  }
  {
    const std::lock_guard lock(mutex_);
    const QuietGdal quiet;
    if (!merc_from_target_->Transform(static_cast<int>(count), x.data(), y.data())) return Unreachable(epsg_);
  }
  std::vector<Eigen::Vector2d> corners;
  corners.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double off_m = std::remainder(x[i] - middle_in_merc_m_, 2.0 * geo::kMercHalfWidthM);
    corners.emplace_back(middle_in_merc_m_ + off_m, y[i]);
  }
  return corners;
}

}  // namespace skyquilt::storage
