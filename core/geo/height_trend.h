// FitHeightTrend: the broad shape of scattered heights: level, a plane, or a plane with a bowl (round, its
// axis vertical). A bowl is what is left when the distortion of a lens is known only as well as photos taken
// straight down tell it: heights bend, and nothing in those photos says so. Frame enu, metres. Pure; any
// thread; same points, same bytes. Never fails: few points are level at their median. Method: least squares
// with Cauchy's weights, of all points alike (FitShape) or over the medians of square cells, the simplest
// shape that explains them (FitHeightTrend).
#pragma once

#include <Eigen/Core>
#include <vector>

namespace skyquilt::geo {

struct HeightTrend {
  enum class Shape { kLevel, kPlane, kBowl };
  Shape shape = Shape::kLevel;
  Eigen::Vector2d center_in_enu = Eigen::Vector2d::Zero();
  double height_m = 0.0;  // at the centre
  Eigen::Vector2d slope = Eigen::Vector2d::Zero();
  double bowl_per_m = 0.0;  // metres up, by the square of the distance from the centre
  double error_m = 0.0;     // half of what it was fitted to lies nearer

  static HeightTrend Level(double height_m) {
    HeightTrend trend;
    trend.height_m = height_m;
    return trend;
  }
  double At(const Eigen::Vector2d& east_north) const {
    const Eigen::Vector2d from_center = east_north - center_in_enu;
    return height_m + slope.dot(from_center) + bowl_per_m * from_center.squaredNorm();
  }
};

// For each square cell that has points, the middle of their places with the median of their heights; from
// west to east, and from south to north between the same meridians.
std::vector<Eigen::Vector3d> CellMedians(const std::vector<Eigen::Vector3d>& points_in_enu, double cell_m);

// That shape through most of the points, however badly it suits them; points within `min_width_m` of it
// count in full, others the less the farther off they are.
HeightTrend FitShape(const std::vector<Eigen::Vector3d>& points_in_enu, HeightTrend::Shape shape,
                     double min_width_m);

HeightTrend FitHeightTrend(const std::vector<Eigen::Vector3d>& points_in_enu, double cell_m);

}  // namespace skyquilt::geo
