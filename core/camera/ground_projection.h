// Between pixels and level ground: where the ray through a pixel meets a level plane, and where a photo shows
// a point of enu, both exactly, through lens and pose. Metres and pixels. Values; any thread.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "core/camera/intrinsics.h"
#include "core/geo/rigid3.h"

namespace skyquilt::camera {

// Where the ray through a pixel meets the plane z = plane_z_m, in enu; nothing for rays that go up or are
// within half a degree of the horizon.
std::optional<Eigen::Vector3d> GroundFromPixel(const Intrinsics& intrinsics, const geo::Rigid3& cam_from_enu,
                                               const Eigen::Vector2d& pixel_in_image, double plane_z_m);
// The pixel that sees a point of enu; nothing if the photo does not see it.
std::optional<Eigen::Vector2d> PixelFromEnu(const Intrinsics& intrinsics, const geo::Rigid3& cam_from_enu,
                                            const Eigen::Vector3d& point_in_enu);

}  // namespace skyquilt::camera
