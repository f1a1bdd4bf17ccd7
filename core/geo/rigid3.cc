#include "core/geo/rigid3.h"

#include <cmath>

namespace skyquilt::geo {

Rigid3 Rigid3::operator*(const Rigid3& source_from_other) const {
  return {(rotation * source_from_other.rotation).normalized(),
          rotation * source_from_other.translation + translation};
}

Rigid3 Rigid3::Inverse() const {
  const Eigen::Quaterniond inverse = rotation.conjugate();
  return {inverse, -(inverse * translation)};
}

Eigen::Vector3d Rigid3::TargetOriginInSource() const { return -(rotation.conjugate() * translation); }

Rigid3 Rigid3::FromRotationAndTargetOrigin(const Eigen::Quaterniond& target_from_source,
                                           const Eigen::Vector3d& target_origin_in_source) {
  return {target_from_source, -(target_from_source * target_origin_in_source)};
}

Eigen::Quaterniond RotationFromVector(const Eigen::Vector3d& omega_rad) {
  const double angle = omega_rad.norm();
  // sin(a/2)/a, by its series near zero.
  const double k = angle < 1e-6 ? 0.5 - angle * angle / 48.0 : std::sin(0.5 * angle) / angle;
  return {std::cos(0.5 * angle), k * omega_rad.x(), k * omega_rad.y(), k * omega_rad.z()};
}

Eigen::Vector3d VectorFromRotation(const Eigen::Quaterniond& rotation) {
  const Eigen::Quaterniond q = rotation.w() < 0.0 ? Eigen::Quaterniond(-rotation.coeffs()) : rotation;
  const double sine = q.vec().norm();
  if (sine < 1e-9) return 2.0 * q.vec();
  return (2.0 * std::atan2(sine, q.w()) / sine) * q.vec();
}

Eigen::Vector3d TurnAgainst(const Rigid3& now, const Rigid3& before) {
  return VectorFromRotation((now.rotation * before.rotation.conjugate()).normalized());
}

Eigen::Quaterniond RotationToZ(const Eigen::Vector3d& direction) {
  const Eigen::Vector3d from = direction.normalized();
  const Eigen::Vector3d to = Eigen::Vector3d::UnitZ();
  const double cosine = to.dot(from);
  if (cosine < -1.0 + 1e-12) return {0.0, 1.0, 0.0, 0.0};  // opposite: half a turn about any level axis
  const double twice = std::sqrt((1.0 + cosine) * 2.0);
  const Eigen::Vector3d axis = from.cross(to) * (1.0 / twice);
  return {0.5 * twice, axis.x(), axis.y(), axis.z()};
}

}  // namespace skyquilt::geo
