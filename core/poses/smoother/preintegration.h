// Preintegration: all inertial samples between two knots summed once into one relative motion, with its
// covariance and its first-order dependence on the biases, so that the smoother never walks the raw samples
// again. Frame: everything is in `body` at the first knot; metres, seconds, radians. Raw sample times are
// used as they are; the rate and force inside a step are the mean of its ends (mid-point), rotated at the
// step's middle. Values; any thread. Where no samples cover an interval there is no preintegration (nullopt),
// not an error. Source: C. Forster et al., On-Manifold Preintegration for Real-Time Visual-Inertial Odometry
// (2017).
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "core/flight/logs/flight_log.h"
#include "core/poses/smoother/chain_state.h"

namespace skyquilt::poses {

inline constexpr double kStandardGravityMps2 = 9.80665;
// Gravity at a latitude and a height over the WGS84 ellipsoid. Source: Somigliana's formula with the free-air
// gradient, as in P. D. Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation (2013).
double NormalGravityMps2(double lat_deg, double height_ellipsoid_m);

using Matrix9d = Eigen::Matrix<double, 9, 9>;

// White noise densities.
struct ImuNoise {
  double gyro_white = 7.0e-5;   // rad/s/sqrt(Hz): 0.004 deg/s/sqrt(Hz)
  double accel_white = 2.0e-3;  // m/s2/sqrt(Hz): 100 ug/sqrt(Hz), doubled in flight
};

struct ImuDelta {
  double duration_s = 0.0;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  // body at start from body at end
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Matrix3d rotation_by_gyro_bias = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d velocity_by_gyro_bias = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d velocity_by_accel_bias = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d position_by_gyro_bias = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d position_by_accel_bias = Eigen::Matrix3d::Zero();
  Eigen::Vector3d gyro_bias = Eigen::Vector3d::Zero();  // the biases the sums were made with
  Eigen::Vector3d accel_bias = Eigen::Vector3d::Zero();
  Eigen::Vector3d end_rate_radps = Eigen::Vector3d::Zero();  // raw, at the end of the interval
  Eigen::Vector3d end_force_mps2 = Eigen::Vector3d::Zero();

  // The state at the end of the interval, from the one at its start (biases are carried over).
  KnotState Predict(const KnotState& start, double gravity_mps2) const;
  Eigen::Matrix3d CorrectedRotation(const Eigen::Vector3d& gyro_bias_now) const;
  Eigen::Vector3d CorrectedVelocity(const KnotState& s) const;
  Eigen::Vector3d CorrectedPosition(const KnotState& s) const;
};

struct Preintegration {
  ImuDelta delta;
  Matrix9d covariance = Matrix9d::Zero();  // of rotation, velocity, position
  std::vector<ImuDelta> at_cuts;           // the same sums from the start up to each asked time
};

// Over [begin_s, end_s], with the sums up to each of `cuts` (rising, inside the interval) kept as well.
// Nothing where the samples leave a hole longer than 0.2 s inside or at the ends of the interval.
std::optional<Preintegration> Preintegrate(const std::vector<flight::ImuSample>& samples, double begin_s,
                                           double end_s, const std::vector<double>& cuts,
                                           const Eigen::Vector3d& gyro_bias,
                                           const Eigen::Vector3d& accel_bias, const ImuNoise& noise);

}  // namespace skyquilt::poses
