// Rigid3: a rigid motion between two frames, named target_from_source. Composes by matching inner names:
// a_from_c = a_from_b * b_from_c. Metres. Values; any thread.
// The rotation is a unit quaternion; errors about it live in the tangent space (radians).
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace skyquilt::geo {

struct Rigid3 {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  Eigen::Vector3d operator*(const Eigen::Vector3d& point_in_source) const {
    return rotation * point_in_source + translation;
  }
  Rigid3 operator*(const Rigid3& source_from_other) const;
  Rigid3 Inverse() const;
  // Where the target frame's origin lies in the source frame; for cam_from_enu the camera's centre in enu.
  Eigen::Vector3d TargetOriginInSource() const;
  static Rigid3 FromRotationAndTargetOrigin(const Eigen::Quaterniond& target_from_source,
                                            const Eigen::Vector3d& target_origin_in_source);
};

// The rotation by |omega| radians about omega (the exponential map), and back.
Eigen::Quaterniond RotationFromVector(const Eigen::Vector3d& omega_rad);
Eigen::Vector3d VectorFromRotation(const Eigen::Quaterniond& rotation);

// By how much the first is turned against the second, both from one source: in the axes of the target.
Eigen::Vector3d TurnAgainst(const Rigid3& now, const Rigid3& before);

// The shortest rotation of this direction (of any length but 0) into that of z. Eigen's FromTwoVectors brings
// a decomposition along for each kind of argument, which takes its callers 15 seconds to compile.
Eigen::Quaterniond RotationToZ(const Eigen::Vector3d& direction);

}  // namespace skyquilt::geo
