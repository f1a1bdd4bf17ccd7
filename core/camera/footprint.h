// From pixels to level ground, through lens and pose: where the ray through a pixel meets a level plane, and
// the footprint: the outline on the ground of what a photo sees, as a polygon in enu (E, N),
// counter-clockwise as seen from above, clipped where the view would run towards the horizon. Metres and
// pixels. Values; any thread.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/camera/intrinsics.h"
#include "core/geo/bounds.h"
#include "core/geo/rigid3.h"

namespace skyquilt::camera {

// Where the ray through a pixel meets the plane z = plane_z_m, in enu; nothing for rays that go up or are
// within half a degree of the horizon.
std::optional<Eigen::Vector3d> GroundFromPixel(const Intrinsics& intrinsics, const geo::Rigid3& cam_from_enu,
                                               const Eigen::Vector2d& pixel_in_image, double plane_z_m);

// Rays steeper than this off the vertical are cut: beyond it a pixel covers metres.
inline constexpr double kMaxViewAngleRad = 1.31;  // 75 degrees
// What a map shows of a photo, unless asked otherwise: beyond it the ground is smeared, and things that stand
// hide it.
inline constexpr double kMaxLookAngleRad = 1.1344640137963142;  // 65 degrees

// Points along the border, `points_per_side` a side, so that lens bending shows. Empty when nothing of the
// photo looks at the ground by less than `max_angle_rad` off the vertical.
std::vector<Eigen::Vector2d> GroundFootprint(const Intrinsics& intrinsics, const geo::Rigid3& cam_from_enu,
                                             double plane_z_m, int points_per_side = 8,
                                             double max_angle_rad = kMaxViewAngleRad);
geo::Bounds2 BoundsOf(const std::vector<Eigen::Vector2d>& polygon);
double AreaM2(const std::vector<Eigen::Vector2d>& polygon);
bool PolygonContains(const std::vector<Eigen::Vector2d>& polygon, const Eigen::Vector2d& point);

}  // namespace skyquilt::camera
