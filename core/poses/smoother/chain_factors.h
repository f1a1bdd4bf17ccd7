// The factors of the chain smoother: each gives its whitened residual and the Jacobians by the small steps of
// the knots it touches and of the border. Frames and units as in chain_state.h. Pure functions; any thread.
// Jacobians are analytic; chain_factors_test compares every one with differences.
#pragma once

#include <Eigen/Core>

#include "core/poses/smoother/chain_state.h"
#include "core/poses/smoother/preintegration.h"

namespace skyquilt::poses {

using Matrix9x22 = Eigen::Matrix<double, 9, kStateSize>;

template <int M>
struct Linear {
  Eigen::Matrix<double, M, 1> residual = Eigen::Matrix<double, M, 1>::Zero();
  Eigen::Matrix<double, M, kStateSize> by_first = Eigen::Matrix<double, M, kStateSize>::Zero();
  Eigen::Matrix<double, M, kStateSize> by_second = Eigen::Matrix<double, M, kStateSize>::Zero();
  Eigen::Matrix<double, M, kStateSize> by_border = Eigen::Matrix<double, M, kStateSize>::Zero();
};

// The state at a time between two knots, with the derivatives of (rotation, velocity, position) by both.
struct StateBetween {
  KnotState state;
  Eigen::Vector3d rate_radps = Eigen::Vector3d::Zero();         // in body
  Eigen::Vector3d acceleration_mps2 = Eigen::Vector3d::Zero();  // in enu
  double weight = 0.0;                                          // of the second knot
  // How far the truth may leave the interpolation, by axis; zero at knots and where inertial samples carry.
  double rotation_variance = 0.0;
  double velocity_variance = 0.0;
  double position_variance = 0.0;
  Matrix9x22 by_first = Matrix9x22::Zero();
  Matrix9x22 by_second = Matrix9x22::Zero();
};
StateBetween StateAtKnot(const KnotState& knot);
// Inertial: carried forward from the first knot.
StateBetween StateByImu(const KnotState& first, const KnotState& second, double weight,
                        const ImuDelta& to_time, double gravity_mps2);
// Without inertial data: the mean of the white-acceleration prior (cubic Hermite) and constant rotation rate.
StateBetween StateByMotionPrior(const KnotState& first, const KnotState& second, double weight,
                                double duration_s, double acceleration_density, double rotation_walk);

// Relative motion from inertial samples; whiten = inverse of the covariance's Cholesky factor.
Linear<9> ImuFactor(const KnotState& first, const KnotState& second, const ImuDelta& delta,
                    const Matrix9d& whiten, double gravity_mps2);
Linear<9> MotionPriorFactor(const KnotState& first, const KnotState& second, double duration_s,
                            double acceleration_density, double rotation_walk);
// Walk of gyro, accelerometer and baro bias, Gauss-Markov of GNSS and attitude bias, as one factor.
struct BiasWalk {
  double gyro = 0.0, accel = 0.0, baro = 0.0;  // standard deviation over the interval
  Eigen::Vector3d gnss = Eigen::Vector3d::Ones(), attitude = Eigen::Vector3d::Ones();
  double gnss_keep = 0.0, attitude_keep = 0.0;  // exp(-T / time)
};
Linear<13> BiasWalkFactor(const KnotState& first, const KnotState& second, const BiasWalk& walk);

Linear<3> PositionFactor(const StateBetween& s, const BorderState& border, const Eigen::Vector3d& measured,
                         const Eigen::Vector3d& sigma);
Linear<3> VelocityFactor(const StateBetween& s, const BorderState& border, const Eigen::Vector3d& measured,
                         const Eigen::Vector3d& sigma);
// The level axes (nose, right, down) that turn with a body's heading, as columns in enu.
Eigen::Matrix3d LevelAxes(const Eigen::Quaterniond& enu_from_body);
// measured = Exp(level axes * attitude bias) R: a compass errs about the vertical, however the body is
// tilted. sigma_yaw apart: very large where the measurement has no yaw.
Linear<3> AttitudeFactor(const StateBetween& s, const Eigen::Quaterniond& measured_enu_from_body,
                         double sigma_tilt, double sigma_yaw);
// The body is level up to the attitude bias.
Linear<2> LevelFactor(const StateBetween& s, double sigma);
// The body's nose points along its velocity up to the yaw part of the attitude bias.
Linear<1> CourseFactor(const StateBetween& s, double sigma);
Linear<1> HeightFactor(const StateBetween& s, double measured_z, double sigma);
Linear<1> RangeFactor(const StateBetween& s, double measured_distance, double ground_z, double sigma);
Linear<3> StillVelocityFactor(const KnotState& knot, double sigma);
Linear<3> StillRotationFactor(const KnotState& first, const KnotState& second, double sigma);
Linear<3> MarkerFactor(const StateBetween& s, const Eigen::Vector3d& measured, double sigma);
Linear<1> YawFactor(const StateBetween& s, double yaw_rad, double sigma);

}  // namespace skyquilt::poses
