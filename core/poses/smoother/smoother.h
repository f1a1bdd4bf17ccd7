// SmoothChain: one offline estimate of a whole flight from any subset of {inertial samples, attitude, GNSS
// position and velocity, barometric height, range, course, stillness, markers}: the
// most probable chain of states at knots in time (one at each photo, and between them every half second),
// with its covariance. Frames: `enu` (the flight's LocalFrame), `body` (x forward, y right, z down). Metres,
// seconds, radians; one clock. One thread; deterministic; time and memory linear in the flight's length
// (about 30 kB per knot). Fails with kUnprocessable where nothing can be estimated (no photos, nothing that
// says where the flight was). Samples that are not finite, repeated or out of order are dropped and counted
// in the report's warnings. Method: Gauss-Newton with step halving on the maximum a posteriori problem, Huber
// weights, envelope Cholesky, covariance by the recursion for selected inverses. Sources: T. D. Barfoot,
// State Estimation for Robotics (2017); C. Forster et al. (2017) for the inertial factor. Replaces
// "detrending" in Iz and Unel.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/flight/logs/flight_log.h"
#include "core/poses/posed_flight.h"
#include "core/poses/smoother/chain_state.h"
#include "core/poses/smoother/preintegration.h"

namespace skyquilt::poses {

struct PositionFix {
  double t_s = 0.0;
  Eigen::Vector3d position_in_enu_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d sigma_m{0.15, 0.15, 0.24};  // white part only; the slow part is the GNSS bias
};

struct VelocityFix {
  double t_s = 0.0;
  Eigen::Vector3d velocity_in_enu_mps = Eigen::Vector3d::Zero();
  Eigen::Vector3d sigma_mps{0.08, 0.08, 0.12};
};

struct AttitudeFix {
  double t_s = 0.0;
  Eigen::Quaterniond enu_from_body = Eigen::Quaterniond::Identity();
  double sigma_rad = 0.0017;  // white part only
  bool has_yaw = true;
};

struct HeightFix {
  double t_s = 0.0;
  double z_in_enu_m = 0.0;
  double sigma_m = 0.15;
};

struct RangeFix {
  double t_s = 0.0;
  double distance_m = 0.0;  // along body down to the ground plane
};

// The aircraft did not move and did not turn.
struct StillInterval {
  double begin_s = 0.0;
  double end_s = 0.0;
};

struct Marker {
  double t_s = 0.0;
  Eigen::Vector3d position_in_enu_m = Eigen::Vector3d::Zero();
  double sigma_m = 0.05;
  std::optional<double> yaw_rad;  // clockwise from north
  double sigma_yaw_rad = 0.035;
};

struct SmootherOptions {
  double gravity_mps2 = kStandardGravityMps2;
  ImuNoise imu;
  double acceleration_density = 1.0;  // (m/s2)^2/Hz, motion prior without inertial data; 4 for fixed wing
  double rotation_walk = 0.349;       // rad/sqrt(s), the same: 20 deg
  Eigen::Vector3d gnss_bias_sigma_m{1.0, 1.0, 1.8};
  Eigen::Vector3d attitude_bias_sigma_rad{0.01047, 0.01047, 0.0436};  // tilt, tilt, yaw: 0.6, 0.6, 2.5 deg
  double attitude_bias_time_s = 40.0;
  double baro_bias_walk = 0.0577;  // m/sqrt(s): 1 m over 300 s
  double baro_bias_first_sigma_m = 0.1;
  bool assume_level = false;     // no attitude: the body is level up to the attitude bias
  bool yaw_from_course = false;  // no yaw: the body points along its course up to the attitude bias
  double huber_sigmas = 3.0;
  // Priors of what is common to the flight; zero sigma = held.
  double tau_gnss_sigma_s = 0.0;
  double tau_camera_sigma_s = 0.0;
  double lever_gnss_sigma_m = 0.0;
  double boresight_sigma_rad = 0.0;
};

struct SmootherInput {
  std::vector<double> photo_times_s;  // rising
  std::vector<flight::ImuSample> imu;
  std::vector<PositionFix> positions;
  std::vector<VelocityFix> velocities;
  std::vector<AttitudeFix> attitudes;
  std::vector<HeightFix> heights;
  std::vector<RangeFix> ranges;
  std::vector<StillInterval> still;
  std::vector<Marker> markers;
  double ground_z_in_enu_m = 0.0;
  SmootherOptions options;
};

// The body (with the camera's boresight and clock offset applied) at one photo. Covariance as in
// PosedPhoto: error = (rotation about enu axes, position), true R = Exp(rotation) * estimate.
struct SmoothedPose {
  double t_s = 0.0;
  Eigen::Quaterniond enu_from_body = Eigen::Quaterniond::Identity();
  Eigen::Vector3d position_in_enu_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_in_enu_mps = Eigen::Vector3d::Zero();
  Matrix6d covariance = Matrix6d::Zero();
  Matrix6d covariance_with_next = Matrix6d::Zero();  // zero for the last
  // The slow error of the attitude system at this time, about the level axes (nose, right, down) of the
  // body's heading: measured = Exp(bias) R; for gimbals that share it.
  Eigen::Vector3d attitude_bias_rad = Eigen::Vector3d::Zero();
};

struct SmootherReport {
  int knots = 0;
  int iterations = 0;
  bool converged = false;
  std::map<std::string, int> used;           // factors by kind
  std::map<std::string, int> down_weighted;  // of them, beyond the Huber bound at the end
  std::vector<std::string> warnings;
};

struct SmootherOutput {
  std::vector<SmoothedPose> poses;  // one per photo, in the order of photo_times_s
  BorderState border;
  Vector22 border_sigma = Vector22::Zero();
  SmootherReport report;
};

Result<SmootherOutput> SmoothChain(const SmootherInput& input);

}  // namespace skyquilt::poses
