// A camera that reads its picture row by row while it flies on: where it stood for a row, and where it sees a
// point. Its pose is that of the middle row; it keeps its direction and speed (a gimbal holds the direction,
// and no speed changes in some hundredths of a second). Frames enu (metres) and image (pixels, rows from the
// top as the sensor reads them). Values; any thread. Source: the fronto-parallel model of Meingast, Geyer and
// Sastry, "Geometric models of rolling-shutter cameras" (2005), for any direction of view.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "core/camera/intrinsics.h"
#include "core/geo/rigid3.h"

namespace skyquilt::camera {

// The place of a row between the first (-0.5) and the last (0.5).
inline double RowShare(double y_px, int height_px) { return (y_px + 0.5) / height_px - 0.5; }

// The pose while that row was read. motion_in_enu_m: of the camera, from the first row to the last.
geo::Rigid3 PoseAtRow(const geo::Rigid3& cam_from_enu, const Eigen::Vector3d& motion_in_enu_m, double y_px,
                      int height_px);

// Where a point is seen; nothing where Intrinsics::Project has nothing. Without motion it is Project.
std::optional<Eigen::Vector2d> ProjectRolling(const Intrinsics& lens, const geo::Rigid3& cam_from_enu,
                                              const Eigen::Vector3d& motion_in_enu_m,
                                              const Eigen::Vector3d& point_in_enu);

}  // namespace skyquilt::camera
