// What houses, walls and trees look like, lit by one sun from the south-west without cast shadows:
// sRGB-encoded colours 0..255, filtered to a footprint in metres. Pure; any thread.
#pragma once

#include <Eigen/Core>

#include "core/simulate/world/standing_object.h"

namespace skyquilt::simulate {

// Tiles on gables, gravel on flat roofs, windows in the sides of houses. `is_side`: the point is on an
// upright side.
Eigen::Vector3f ObjectColor(const StandingObject& object, const Eigen::Vector3d& point_in_enu, bool is_side,
                            float footprint_m);

}  // namespace skyquilt::simulate
