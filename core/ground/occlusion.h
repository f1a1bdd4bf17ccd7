// IsOccluded: whether something stands between a point of a stepped ground surface and whoever looks at it:
// walks the line over the cells, squares of cells at a time where nothing there is as high. Things less than
// a cell high over the line, and the point's own surroundings, do not hide. Points in enu, metres; the eye
// lies above the surface. Pure; any thread.
#pragma once

#include <Eigen/Core>

#include "core/ground/ground_surface.h"

namespace skyquilt::ground {

bool IsOccluded(const GroundSurface& surface, const Eigen::Vector3d& point_in_enu,
                const Eigen::Vector3d& eye_in_enu);

}  // namespace skyquilt::ground
