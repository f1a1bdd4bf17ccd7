// The cost terms of the bundle adjustment, each in units of its own sigma, written for automatic
// differentiation. Poses are six numbers from a fixed start: turn (radians, in cam: cam = Exp(turn) * start)
// and shift of the centre (enu metres). Lens: focal as a factor, centre in pixels, k1 k2, p1 p2. Included by
// the two .cc files that solve with Ceres.
#pragma once

#include <ceres/rotation.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace skyquilt::alignment {

inline constexpr int kPoseSize = 6;
inline constexpr int kLensSize = 7;  // log focal factor, cx, cy, k1, k2, p1, p2

// Where the photo saw a point against where pose and lens say it should be.
struct ReprojectionResidual {
  Eigen::Matrix3d start_rotation;  // cam_from_enu
  Eigen::Vector3d start_center_in_enu;
  Eigen::Vector2d focal_px;
  Eigen::Vector2d center_px;
  double k3;
  Eigen::Vector2d pixel;
  double sigma_px;

  template <typename T>
  bool operator()(const T* pose, const T* point, const T* lens, T* residual) const {
    using Vector3 = Eigen::Matrix<T, 3, 1>;
    const Vector3 away(point[0] - pose[3] - start_center_in_enu.x(),
                       point[1] - pose[4] - start_center_in_enu.y(),
                       point[2] - pose[5] - start_center_in_enu.z());
    const Vector3 turned = start_rotation.cast<T>() * away;
    T in_cam[3];
    ceres::AngleAxisRotatePoint(pose, turned.data(), in_cam);
    if (in_cam[2] < T(1e-3)) return false;
    const T x = in_cam[0] / in_cam[2];
    const T y = in_cam[1] / in_cam[2];
    const T r2 = x * x + y * y;
    const T radial = T(1.0) + r2 * (lens[3] + r2 * (lens[4] + r2 * k3));
    const T bent_x = x * radial + T(2.0) * lens[5] * x * y + lens[6] * (r2 + T(2.0) * x * x);
    const T bent_y = y * radial + lens[5] * (r2 + T(2.0) * y * y) + T(2.0) * lens[6] * x * y;
    const T focal = exp(lens[0]);
    residual[0] = (focal * focal_px.x() * bent_x + center_px.x() + lens[1] - pixel.x()) / sigma_px;
    residual[1] = (focal * focal_px.y() * bent_y + center_px.y() + lens[2] - pixel.y()) / sigma_px;
    return true;
  }
};

// The recorded attitude, apart from an error that the whole flight line shares (in cam).
struct AttitudeResidual {
  Eigen::Vector3d start_from_prior_rad;  // Log(start * prior^-1), small
  Eigen::Vector3d sigma_rad;

  template <typename T>
  bool operator()(const T* pose, const T* line_bias, T* residual) const {
    for (int k = 0; k < 3; ++k)
      residual[k] = (pose[k] + start_from_prior_rad[k] - line_bias[k]) / sigma_rad[k];
    return true;
  }
};

// The recorded position, apart from an error that the whole flight shares.
struct PositionResidual {
  Eigen::Vector3d start_from_prior_m;
  Eigen::Vector3d sigma_m;

  template <typename T>
  bool operator()(const T* pose, const T* bias, T* residual) const {
    for (int k = 0; k < 3; ++k) residual[k] = (pose[3 + k] + start_from_prior_m[k] - bias[k]) / sigma_m[k];
    return true;
  }
};

template <int kSize>
struct PriorResidual {
  Eigen::Matrix<double, kSize, 1> expected;
  Eigen::Matrix<double, kSize, 1> sigma;

  template <typename T>
  bool operator()(const T* value, T* residual) const {
    for (int k = 0; k < kSize; ++k) residual[k] = (value[k] - expected[k]) / sigma[k];
    return true;
  }
};

// A point that only direct registration knows lies near the ground.
struct PointHeightResidual {
  double expected_z_m;
  double sigma_m;

  template <typename T>
  bool operator()(const T* point, T* residual) const {
    residual[0] = (point[2] - expected_z_m) / sigma_m;
    return true;
  }
};

// The ground is more or less a plane.
struct PlaneResidual {
  Eigen::Vector3d plane;  // z = plane.x + plane.y * E + plane.z * N
  double sigma_m;

  template <typename T>
  bool operator()(const T* point, T* residual) const {
    residual[0] = (point[2] - plane.x() - plane.y() * point[0] - plane.z() * point[1]) / sigma_m;
    return true;
  }
};

}  // namespace skyquilt::alignment
