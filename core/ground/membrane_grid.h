// FitMembrane: a regular grid of heights through scattered points: where there are points it follows their
// medians, between them it is stretched like a membrane, far from them it settles on the broad shape. Frame
// enu, metres. Pure; any thread; same points, same bytes. Method: nested iteration (coarse to fine) of
// successive over-relaxation.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/ground/ground_surface.h"

namespace skyquilt::ground {

struct MembraneGrid {
  Eigen::Vector2d south_west_in_enu = Eigen::Vector2d::Zero();
  double cell_m = 1.0;
  int columns = 0, rows = 0;
  std::vector<float> heights_m;  // row by row from the south-west
};

// Reaches `margin_m` beyond the points. `stiffness`: how much neighbouring cells must agree, against the
// weight 1 of a single point.
MembraneGrid FitMembrane(const std::vector<Eigen::Vector3d>& points_in_enu, double cell_m,
                         const GroundSurface& broad_shape, double margin_m, double stiffness);

}  // namespace skyquilt::ground
