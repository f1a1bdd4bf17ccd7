// The unknowns of the chain smoother: 22 per knot, and one border block of unknowns that are common to the
// whole flight. Frames: `enu`, `body`. A small step `delta` moves a rotation by R <- R Exp(delta) and adds to
// all else. Values; any thread.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/geo/rigid3.h"

namespace skyquilt::poses {

inline constexpr int kStateSize = 22;
using Vector22 = Eigen::Matrix<double, kStateSize, 1>;
using Matrix22 = Eigen::Matrix<double, kStateSize, kStateSize>;

// Where each unknown of a knot begins in its 22-vector.
inline constexpr int kAtRotation = 0;
inline constexpr int kAtVelocity = 3;
inline constexpr int kAtPosition = 6;
inline constexpr int kAtGyroBias = 9;
inline constexpr int kAtAccelBias = 12;
inline constexpr int kAtGnssBias = 15;
inline constexpr int kAtAttitudeBias = 18;
inline constexpr int kAtBaroBias = 21;

struct KnotState {
  Eigen::Quaterniond enu_from_body = Eigen::Quaterniond::Identity();
  Eigen::Vector3d velocity_in_enu_mps = Eigen::Vector3d::Zero();
  Eigen::Vector3d position_in_enu_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d gyro_bias_radps = Eigen::Vector3d::Zero();
  Eigen::Vector3d accel_bias_mps2 = Eigen::Vector3d::Zero();
  Eigen::Vector3d gnss_bias_in_enu_m = Eigen::Vector3d::Zero();  // measured = true + bias
  Eigen::Vector3d attitude_bias_rad = Eigen::Vector3d::Zero();   // measured = Exp(bias about level axes) R
  double baro_bias_m = 0.0;                                      // measured = true + bias

  KnotState Moved(const Vector22& delta) const {
    KnotState s = *this;
    s.enu_from_body = (enu_from_body * geo::RotationFromVector(delta.segment<3>(kAtRotation))).normalized();
    s.velocity_in_enu_mps += delta.segment<3>(kAtVelocity);
    s.position_in_enu_m += delta.segment<3>(kAtPosition);
    s.gyro_bias_radps += delta.segment<3>(kAtGyroBias);
    s.accel_bias_mps2 += delta.segment<3>(kAtAccelBias);
    s.gnss_bias_in_enu_m += delta.segment<3>(kAtGnssBias);
    s.attitude_bias_rad += delta.segment<3>(kAtAttitudeBias);
    s.baro_bias_m += delta(kAtBaroBias);
    return s;
  }
};

// The border: unknowns of the whole flight, each with a prior (a prior sigma of zero holds it at its value).
inline constexpr int kAtTauGnss = 0;    // a GNSS fix stamped t was true at t + tau
inline constexpr int kAtLeverGnss = 1;  // antenna in body
inline constexpr int kAtTauCamera = 4;  // a photo stamped t was taken at t + tau
inline constexpr int kAtBoresight = 5;  // true camera rotation = nominal, then Exp(boresight) in body
inline constexpr int kBorderUsed = 8;

struct BorderState {
  Vector22 value = Vector22::Zero();
  double TauGnss() const { return value(kAtTauGnss); }
  Eigen::Vector3d LeverGnss() const { return value.segment<3>(kAtLeverGnss); }
  double TauCamera() const { return value(kAtTauCamera); }
  Eigen::Vector3d Boresight() const { return value.segment<3>(kAtBoresight); }
};

}  // namespace skyquilt::poses
