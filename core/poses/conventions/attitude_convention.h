// From recorded angles to camera rotations and back. Frames `cam` and `enu` (core/geo/README.md); angles in
// radians: yaw clockwise from true north, pitch 0 = horizon and -pi/2 = straight down, roll right side down.
// Pure functions; any thread. Method: intrinsic Z-Y-X rotations in NED of a gimbal frame (x along the optical
// axis, y image right, z image down), checked against bundle-adjusted oblique frames.
#pragma once

#include <Eigen/Geometry>

#include "core/flight/photo.h"

namespace skyquilt::poses {

// For AttitudeKind::kAirframe the camera is taken as fixed to the body: it looks along the body's down axis
// and the top of the image points forward.
Eigen::Quaterniond CamFromEnu(const flight::RecordedAttitude& attitude);
// A camera that looks straight down with the top of the image towards `yaw_rad`.
Eigen::Quaterniond NadirCamFromEnu(double yaw_rad);
// The body frame (x forward, y right, z down) that carries a down-looking camera fixed to it.
Eigen::Quaterniond CamFromBody();
// The gimbal frame: x along the optical axis, y image right, z image down.
Eigen::Quaterniond CamFromGimbal();
Eigen::Quaterniond EnuFromNed();

struct CameraAngles {
  double yaw_rad = 0.0;
  double pitch_rad = 0.0;
  double roll_rad = 0.0;
};
// Angles for people. Within 45 degrees of straight down the yaw is the heading of the image's top, pitch + 90
// degrees its lift and roll the tilt to its right, which stay steady where gimbal angles turn singular; both
// readings are equal for a camera without roll. Further out they are the gimbal angles.
CameraAngles AnglesOf(const Eigen::Quaterniond& cam_from_enu);

}  // namespace skyquilt::poses
