// A camera that reads its picture row by row while it flies on and turns: how it stood for a row, and where
// it sees a point. Its pose is that of the middle row; no speed changes in some hundredths of a second, the
// direction may, as a gyro recorded it (a gimbal holds it: then there are no turns). Frames enu (metres), cam
// and image (pixels, rows from the top as the sensor reads them). Values; any thread. Source: Meingast, Geyer
// and Sastry, "Geometric models of rolling-shutter cameras" (2005); for turns Karpenko and others, "Digital
// video stabilization and rolling shutter correction using gyroscopes" (2011).
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/camera/intrinsics.h"
#include "core/geo/rigid3.h"

namespace skyquilt::camera {

// How a camera moves from the first row of its picture to the last.
struct RowMotion {
  Eigen::Vector3d shift_in_enu_m = Eigen::Vector3d::Zero();
  // How the camera stands at rows evenly spaced from the first to the last, against the middle row: rotation
  // vectors of row_from_middle, in cam. Between them linear. Empty: it keeps its direction.
  std::vector<Eigen::Vector3d> turns_rad;

  bool IsStill() const { return shift_in_enu_m.isZero(0.0) && turns_rad.empty(); }
  // row_from_middle for a row's share; the first and last also beyond the picture.
  Eigen::Quaterniond TurnAt(double share) const;

  bool operator==(const RowMotion&) const = default;
};

// The place of a row between the first (-0.5) and the last (0.5).
inline double RowShare(double y_px, int height_px) { return (y_px + 0.5) / height_px - 0.5; }

// The pose while that row was read.
geo::Rigid3 PoseAtRow(const geo::Rigid3& cam_from_enu, const RowMotion& motion, double y_px, int height_px);

// Where a point is seen; nothing where Intrinsics::Project has nothing, or where the camera turns so fast
// that no row can be said to see it. Without motion it is Project.
std::optional<Eigen::Vector2d> ProjectRolling(const Intrinsics& lens, const geo::Rigid3& cam_from_enu,
                                              const RowMotion& motion, const Eigen::Vector3d& point_in_enu);

}  // namespace skyquilt::camera
