// FitMembrane: a regular grid of heights through scattered points: where there are points it follows their
// medians, between them it is stretched like a membrane, far from them it settles on the mean. Frame enu,
// metres. Pure; any thread; same points, same bytes. Method: nested iteration (coarse to fine) of successive
// over-relaxation.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace skyquilt::ground {

struct MembraneGrid {
  Eigen::Vector2d south_west_in_enu = Eigen::Vector2d::Zero();
  double cell_m = 1.0;
  int columns = 0, rows = 0;
  std::vector<float> heights_m;  // row by row from the south-west
};

// `stiffness`: how much neighbouring cells must agree, against the weight 1 of a single point.
MembraneGrid FitMembrane(const std::vector<Eigen::Vector3d>& points_in_enu, double cell_m, double mean_z_m,
                         double stiffness);

}  // namespace skyquilt::ground
