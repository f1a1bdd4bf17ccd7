#include "core/poses/conventions/attitude_convention.h"

#include <cmath>

#include "core/flight/logs/log_builder.h"
#include "core/geo/lat_lon.h"

namespace skyquilt::poses {

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

Eigen::Quaterniond CamFromEnu(const flight::RecordedAttitude& attitude) {
  const Eigen::Quaterniond ned_from_frame =
      flight::NedFromYawPitchRoll(attitude.yaw_rad, attitude.pitch_rad, attitude.roll_rad);
  const Eigen::Quaterniond cam_from_frame =
      attitude.kind == flight::AttitudeKind::kGimbal ? CamFromGimbal() : CamFromBody();
  return (cam_from_frame * ned_from_frame.conjugate() * EnuFromNed().conjugate()).normalized();
}

Eigen::Quaterniond NadirCamFromEnu(double yaw_rad) {
  return CamFromEnu({flight::AttitudeKind::kAirframe, yaw_rad, 0.0, 0.0, ""});
}

CameraAngles AnglesOf(const Eigen::Quaterniond& cam_from_enu) {
  const Eigen::Vector3d axis_in_enu = cam_from_enu.conjugate() * Eigen::Vector3d::UnitZ();
  const bool looks_down = axis_in_enu.z() < -std::sqrt(0.5);
  const Eigen::Quaterniond cam_from_frame = looks_down ? CamFromBody() : CamFromGimbal();
  const Eigen::Vector3d angles =
      flight::YawPitchRollFromNed(EnuFromNed().conjugate() * cam_from_enu.conjugate() * cam_from_frame);
  return {angles.x(), angles.y() - (looks_down ? 0.5 * geo::kPi : 0.0), angles.z()};
}

}  // namespace skyquilt::poses
