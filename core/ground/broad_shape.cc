#include "core/ground/broad_shape.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "core/geo/bounds.h"
#include "core/geo/height_trend.h"

namespace skyquilt::ground {
namespace {

// All in flying heights.
constexpr double kCell = 0.2;
constexpr double kNear = 0.3;          // sigma of the weights
constexpr double kGoesOn = 0.35;       // how far a slope is carried on
constexpr double kFarInNear = 3.0;     // in sigmas: beyond, nothing counts
constexpr double kTrendWeight = 0.01;  // of the trend, against 1 for a cell right here
constexpr double kSlopeHold = 0.05;
// Over a wide land flown low the cells grow instead of their number.
constexpr double kMaxBroadCells = 250'000.0;

// What lies above the trend at a place. Each row's cells lie from west to east.
double AboveTrend(const std::vector<std::vector<Eigen::Vector3d>>& rows, const Eigen::Vector2d& place,
                  double south_m, double cell_m, double height_m) {
  const double near_m = kNear * height_m;
  double weight = 0.0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d square = Eigen::Matrix3d::Zero();
  const auto row_of = [&](double north) {
    return std::clamp<long>(std::lround((north - south_m) / cell_m), 0, static_cast<long>(rows.size()) - 1);
  };
  const long last = row_of(place.y() + kFarInNear * near_m);
  for (long row = row_of(place.y() - kFarInNear * near_m); row <= last; ++row) {
    const std::vector<Eigen::Vector3d>& cells = rows[static_cast<std::size_t>(row)];
    const double west = place.x() - kFarInNear * near_m, east = place.x() + kFarInNear * near_m;
    auto cell = std::partition_point(cells.begin(), cells.end(),
                                     [&](const Eigen::Vector3d& one) { return one.x() < west; });
    for (; cell != cells.end() && cell->x() <= east; ++cell) {
      Eigen::Vector3d from_place = *cell;
      from_place.head<2>() -= place;
      const double far2 = from_place.head<2>().squaredNorm() / (near_m * near_m);
      if (far2 > kFarInNear * kFarInNear) continue;
      const double counts = std::exp(-0.5 * far2);
      weight += counts;
      sum += counts * from_place;
      square += counts * from_place * from_place.transpose();
    }
  }
  if (weight <= 0.0) return 0.0;
  const Eigen::Vector3d mean = sum / weight;
  const Eigen::Matrix3d spread = square / weight - mean * mean.transpose();
  const Eigen::Matrix2d held =
      spread.topLeftCorner<2, 2>() + kSlopeHold * near_m * near_m * Eigen::Matrix2d::Identity();
  const Eigen::Vector2d slope = held.ldlt().solve(Eigen::Vector2d(spread.col(2).head<2>()));
  const double explained = slope.dot(spread.topLeftCorner<2, 2>() * slope);
  const double share = spread(2, 2) > 0.0 ? std::min(1.0, explained / spread(2, 2)) : 0.0;
  Eigen::Vector2d to_place = -mean.head<2>();
  const double far_m = to_place.norm();
  if (far_m > kGoesOn * height_m) to_place *= kGoesOn * height_m / far_m;
  return weight / (weight + kTrendWeight) * (mean.z() + share * slope.dot(to_place));
}

}  // namespace

GroundSurface BroadShape(const std::vector<Eigen::Vector3d>& points_in_enu, double flown_height_m,
                         double margin_m) {
  geo::Bounds2 bounds;
  for (const Eigen::Vector3d& point : points_in_enu) bounds.Include(Eigen::Vector2d(point.head<2>()));
  double cell_m = kCell * flown_height_m;
  if (!bounds.IsEmpty()) {
    const double area_m2 = (bounds.Width() + 2.0 * margin_m) * (bounds.Height() + 2.0 * margin_m);
    cell_m = std::max(cell_m, std::sqrt(area_m2 / kMaxBroadCells));
  }
  const geo::HeightTrend trend = geo::FitHeightTrend(points_in_enu, cell_m);
  if (bounds.IsEmpty()) return GroundSurface::Plane(trend.height_m);
  const Eigen::Vector2d south_west = bounds.min - Eigen::Vector2d::Constant(margin_m);
  const int columns = static_cast<int>(std::ceil((bounds.Width() + 2.0 * margin_m) / cell_m)) + 2;
  const int count = static_cast<int>(std::ceil((bounds.Height() + 2.0 * margin_m) / cell_m)) + 2;
  std::vector<std::vector<Eigen::Vector3d>> rows(static_cast<std::size_t>(count));
  for (Eigen::Vector3d cell : geo::CellMedians(points_in_enu, cell_m)) {
    cell.z() -= trend.At(cell.head<2>());
    rows[static_cast<std::size_t>(std::lround((cell.y() - south_west.y()) / cell_m))].push_back(cell);
  }
  for (std::vector<Eigen::Vector3d>& row : rows) {
    std::sort(row.begin(), row.end(),
              [](const Eigen::Vector3d& a, const Eigen::Vector3d& b) { return a.x() < b.x(); });
  }
  std::vector<float> heights;
  heights.reserve(static_cast<std::size_t>(columns) * count);
  for (int row = 0; row < count; ++row) {
    for (int column = 0; column < columns; ++column) {
      const Eigen::Vector2d place = south_west + cell_m * Eigen::Vector2d(column, row);
      heights.push_back(static_cast<float>(trend.At(place) +
                                           AboveTrend(rows, place, south_west.y(), cell_m, flown_height_m)));
    }
  }
  return GroundSurface::Grid(south_west, cell_m, columns, count, std::move(heights), trend.height_m);
}

}  // namespace skyquilt::ground
