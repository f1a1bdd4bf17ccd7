// The plane-induced homography: where the ground point (E, N) of the plane z = z0 appears in a photo, before
// the lens bends it. G = K R [e1 e2 (z0 e3 - C)] maps (E, N, 1) in enu metres to undistorted pixels; R, C
// from cam_from_enu. Undistort before, distort after. Values; any thread. Source: Hartley and Zisserman,
// Multiple View Geometry, 2nd ed., section 13.1; replaces equations (4)-(16) of Iz and Unel.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "core/camera/intrinsics.h"
#include "core/geo/rigid3.h"

namespace skyquilt::camera {

Eigen::Matrix3d GroundHomography(const Intrinsics& intrinsics, const geo::Rigid3& cam_from_enu,
                                 double plane_z_m);

// Where the ray through a pixel meets the plane z = plane_z_m, in enu; nothing for rays that go up or are
// within half a degree of the horizon.
std::optional<Eigen::Vector3d> GroundFromPixel(const Intrinsics& intrinsics, const geo::Rigid3& cam_from_enu,
                                               const Eigen::Vector2d& pixel_in_image, double plane_z_m);
// The pixel that sees a point of enu; nothing if the photo does not see it.
std::optional<Eigen::Vector2d> PixelFromEnu(const Intrinsics& intrinsics, const geo::Rigid3& cam_from_enu,
                                            const Eigen::Vector3d& point_in_enu);

}  // namespace skyquilt::camera
