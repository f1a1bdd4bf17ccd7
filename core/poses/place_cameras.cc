#include "core/poses/place_cameras.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/poses/smoother/chain_factors.h"
#include "core/poses/so3.h"

namespace skyquilt::poses {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

// Where the optical axis meets the ground plane, by the pose's small errors; for the error radius.
double CenterErrorM(const PlacedCamera& camera, double ground_z) {
  const Quaterniond enu_from_cam = camera.cam_from_enu.rotation.conjugate();
  const Vector3d center = camera.cam_from_enu.TargetOriginInSource();
  const Vector3d axis = enu_from_cam * Vector3d::UnitZ();
  const double along = (ground_z - center.z()) / std::min(axis.z(), -0.1);
  const Vector3d ray = along * axis;
  // Position moves the point as it is; a turn moves it by turn x ray; both then slide along the axis to the
  // plane.
  Matrix3d to_plane = Matrix3d::Identity();
  to_plane.col(2) -= axis / std::min(axis.z(), -0.1);
  Eigen::Matrix<double, 3, 6> by_pose;
  by_pose << -Skew(ray), Matrix3d::Identity();
  const Eigen::Matrix<double, 2, 6> on_ground = (to_plane * by_pose).topRows<2>();
  const double trace = (on_ground * camera.covariance * on_ground.transpose()).trace();
  return std::sqrt(std::max(0.0, trace));
}

}  // namespace

std::vector<PlacedCamera> PlaceCameras(const PreparedSmoothing& prepared, const SmootherOutput& smoothed,
                                       double ground_z_in_enu_m) {
  constexpr double kGimbalWhiteRad = 0.005;  // the gimbal's own jitter about the airframe's attitude
  std::vector<PlacedCamera> cameras;
  for (std::size_t k = 0; k < smoothed.poses.size(); ++k) {
    const SmoothedPose& pose = smoothed.poses[k];
    PlacedCamera camera;
    camera.covariance = pose.covariance;
    camera.covariance_with_next = pose.covariance_with_next;
    const Vector3d& v = pose.velocity_in_enu_mps;
    camera.covariance.bottomRightCorner<3, 3>() += std::pow(prepared.time_sigma_s[k], 2) * v * v.transpose();
    camera.velocity_in_enu_mps = pose.velocity_in_enu_mps;
    camera.attitude_origin = prepared.attitude_origins[k];
    Quaterniond enu_from_cam = pose.enu_from_body * prepared.cam_from_body[k].conjugate();
    if (const std::optional<Quaterniond>& recorded = prepared.recorded_enu_from_cam[k]) {
      // Measured airframe = Exp(level axes * bias) R: the attitude system is turned by that, and the gimbal
      // too.
      const Vector3d turned = LevelAxes(pose.enu_from_body) * pose.attitude_bias_rad;
      enu_from_cam = geo::RotationFromVector(-turned) * *recorded;
      camera.covariance.topLeftCorner<3, 3>().diagonal().array() += kGimbalWhiteRad * kGimbalWhiteRad;
    }
    camera.cam_from_enu = geo::Rigid3::FromRotationAndTargetOrigin(enu_from_cam.normalized().conjugate(),
                                                                   pose.position_in_enu_m);
    camera.error_radius_m = CenterErrorM(camera, ground_z_in_enu_m);
    cameras.push_back(camera);
  }
  return cameras;
}

}  // namespace skyquilt::poses
