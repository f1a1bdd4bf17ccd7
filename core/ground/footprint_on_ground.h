// FootprintOnGround: the outline of what a photo sees, where its rays meet the modelled ground: as
// GroundFootprint of core/camera, in enu (E, N), counter-clockwise as seen from above, but over hills instead
// of a plane. Empty when nothing of the photo looks at the ground. Rays are walked to the ground by
// fixed-point steps: to a centimetre where the ground is flatter than the ray is steep. Pure; any thread.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/camera/intrinsics.h"
#include "core/geo/rigid3.h"
#include "core/ground/ground_surface.h"

namespace skyquilt::ground {

std::vector<Eigen::Vector2d> FootprintOnGround(const GroundSurface& ground,
                                               const camera::Intrinsics& intrinsics,
                                               const geo::Rigid3& cam_from_enu, int points_per_side = 8);

}  // namespace skyquilt::ground
