// The small calculus of rotations that the pose factors share: skew matrix, exponential, logarithm and the
// Jacobians of the exponential map. Radians. Pure functions; any thread.
// Source: T. D. Barfoot, State Estimation for Robotics (2017), section 7.1; C. Forster et al., On-Manifold
// Preintegration (2017), equations 7-9.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

#include "core/geo/rigid3.h"

namespace skyquilt::poses {

inline Eigen::Matrix3d Skew(const Eigen::Vector3d& w) {
  Eigen::Matrix3d s;
  s << 0.0, -w.z(), w.y(), w.z(), 0.0, -w.x(), -w.y(), w.x(), 0.0;
  return s;
}

inline Eigen::Matrix3d ExpSo3(const Eigen::Vector3d& w) {
  return geo::RotationFromVector(w).toRotationMatrix();
}
inline Eigen::Vector3d LogSo3(const Eigen::Quaterniond& q) { return geo::VectorFromRotation(q); }

// Exp(w + dw) = Exp(w) Exp(RightJacobian(w) dw) = Exp(LeftJacobian(w) dw) Exp(w), to first order.
inline Eigen::Matrix3d LeftJacobian(const Eigen::Vector3d& w) {
  const double angle_squared = w.squaredNorm();
  const Eigen::Matrix3d s = Skew(w);
  if (angle_squared < 1e-8) return Eigen::Matrix3d::Identity() + 0.5 * s + s * s / 6.0;
  const double angle = std::sqrt(angle_squared);
  return Eigen::Matrix3d::Identity() + ((1.0 - std::cos(angle)) / angle_squared) * s +
         ((angle - std::sin(angle)) / (angle_squared * angle)) * (s * s);
}
inline Eigen::Matrix3d RightJacobian(const Eigen::Vector3d& w) { return LeftJacobian(-w); }

inline Eigen::Matrix3d LeftJacobianInverse(const Eigen::Vector3d& w) {
  const double angle_squared = w.squaredNorm();
  const Eigen::Matrix3d s = Skew(w);
  if (angle_squared < 1e-8) return Eigen::Matrix3d::Identity() - 0.5 * s + s * s / 12.0;
  const double half = 0.5 * std::sqrt(angle_squared);
  const double k = (1.0 - half * std::cos(half) / std::sin(half)) / angle_squared;
  return Eigen::Matrix3d::Identity() - 0.5 * s + k * (s * s);
}
inline Eigen::Matrix3d RightJacobianInverse(const Eigen::Vector3d& w) { return LeftJacobianInverse(-w); }

}  // namespace skyquilt::poses
