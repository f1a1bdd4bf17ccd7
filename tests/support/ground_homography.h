// The plane-induced homography, as textbooks write it: G = K R [e1 e2 (z0 e3 - C)] maps (E, N, 1) in enu
// metres of the plane z = z0 to undistorted pixels; R, C from cam_from_enu. What the exact projections are
// compared with. Source: Hartley and Zisserman, Multiple View Geometry, 2nd ed., section 13.1.
#pragma once

#include <Eigen/Core>

#include "core/camera/intrinsics.h"
#include "core/geo/rigid3.h"

namespace skyquilt::test {

inline Eigen::Matrix3d GroundHomography(const camera::Intrinsics& intrinsics, const geo::Rigid3& cam_from_enu,
                                        double plane_z_m) {
  Eigen::Matrix3d plane;  // (E, N, 1) to the point relative to the camera centre, in enu
  plane.col(0) = Eigen::Vector3d::UnitX();
  plane.col(1) = Eigen::Vector3d::UnitY();
  plane.col(2) = plane_z_m * Eigen::Vector3d::UnitZ() - cam_from_enu.TargetOriginInSource();
  return intrinsics.K() * cam_from_enu.rotation.toRotationMatrix() * plane;
}

}  // namespace skyquilt::test
