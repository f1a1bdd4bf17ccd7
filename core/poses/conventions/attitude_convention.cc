#include "core/poses/conventions/attitude_convention.h"

#include <algorithm>
#include <cmath>

#include "core/geo/lat_lon.h"

namespace skyquilt::poses {
namespace {

// Yaw, pitch, roll of a Z-Y-X rotation whose pitch is not near +-90 degrees.
CameraAngles ZyxAngles(const Eigen::Matrix3d& ned_from_frame) {
  return {std::atan2(ned_from_frame(1, 0), ned_from_frame(0, 0)),
          std::asin(std::clamp(-ned_from_frame(2, 0), -1.0, 1.0)),
          std::atan2(ned_from_frame(2, 1), ned_from_frame(2, 2))};
}

}  // namespace

Eigen::Quaterniond CamFromGimbal() {
  Eigen::Matrix3d m;
  m << 0, 1, 0, 0, 0, 1, 1, 0, 0;
  return Eigen::Quaterniond(m);
}

Eigen::Quaterniond CamFromBody() {
  Eigen::Matrix3d m;
  m << 0, 1, 0, -1, 0, 0, 0, 0, 1;
  return Eigen::Quaterniond(m);
}

Eigen::Quaterniond EnuFromNed() {
  Eigen::Matrix3d m;
  m << 0, 1, 0, 1, 0, 0, 0, 0, -1;
  return Eigen::Quaterniond(m);
}

Eigen::Quaterniond NedFromBody(double yaw_rad, double pitch_rad, double roll_rad) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()) *
                            Eigen::AngleAxisd(pitch_rad, Eigen::Vector3d::UnitY()) *
                            Eigen::AngleAxisd(roll_rad, Eigen::Vector3d::UnitX()));
}

Eigen::Quaterniond CamFromEnu(const flight::RecordedAttitude& attitude) {
  const Eigen::Quaterniond ned_from_frame =
      NedFromBody(attitude.yaw_rad, attitude.pitch_rad, attitude.roll_rad);
  const Eigen::Quaterniond cam_from_frame =
      attitude.kind == flight::AttitudeKind::kGimbal ? CamFromGimbal() : CamFromBody();
  return (cam_from_frame * ned_from_frame.conjugate() * EnuFromNed().conjugate()).normalized();
}

Eigen::Quaterniond NadirCamFromEnu(double yaw_rad) {
  return (CamFromBody() * NedFromBody(yaw_rad, 0.0, 0.0).conjugate() * EnuFromNed().conjugate()).normalized();
}

CameraAngles AnglesOf(const Eigen::Quaterniond& cam_from_enu) {
  const Eigen::Vector3d axis_in_enu = cam_from_enu.conjugate() * Eigen::Vector3d::UnitZ();
  const Eigen::Quaterniond ned_from_cam = EnuFromNed().conjugate() * cam_from_enu.conjugate();
  if (axis_in_enu.z() < -std::sqrt(0.5)) {
    CameraAngles angles = ZyxAngles((ned_from_cam * CamFromBody()).toRotationMatrix());
    angles.pitch_rad -= 0.5 * geo::kPi;
    return angles;
  }
  return ZyxAngles((ned_from_cam * CamFromGimbal()).toRotationMatrix());
}

}  // namespace skyquilt::poses
