#include "core/camera/intrinsics.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace skyquilt::camera {

Intrinsics Intrinsics::Centered(int width_px, int height_px, double focal_px) {
  Intrinsics camera;
  camera.width_px = width_px;
  camera.height_px = height_px;
  camera.focal_x_px = camera.focal_y_px = focal_px;
  camera.center_x_px = 0.5 * (width_px - 1);
  camera.center_y_px = 0.5 * (height_px - 1);
  return camera;
}

Eigen::Matrix3d Intrinsics::K() const {
  Eigen::Matrix3d k;
  k << focal_x_px, 0.0, center_x_px, 0.0, focal_y_px, center_y_px, 0.0, 0.0, 1.0;
  return k;
}

Eigen::Vector2d Intrinsics::Undistort(const Eigen::Vector2d& distorted) const {
  if (!HasDistortion()) return distorted;
  // Newton on the two equations, from the distorted point; the Jacobian is well conditioned inside the fold.
  Eigen::Vector2d guess = distorted;
  for (int i = 0; i < 20; ++i) {
    const double x = guess.x();
    const double y = guess.y();
    const double r2 = x * x + y * y;
    const double radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
    const double slope = k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3);  // d radial / d r2
    Eigen::Matrix2d jacobian;
    jacobian(0, 0) = radial + 2.0 * x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x;
    jacobian(0, 1) = 2.0 * x * y * slope + 2.0 * p1 * x + 2.0 * p2 * y;
    jacobian(1, 0) = jacobian(0, 1);
    jacobian(1, 1) = radial + 2.0 * y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x;
    const double determinant = jacobian(0, 0) * jacobian(1, 1) - jacobian(0, 1) * jacobian(1, 0);
    if (std::abs(determinant) < 1e-9) break;
    const Eigen::Vector2d error = Distort(guess) - distorted;
    const Eigen::Vector2d step{(jacobian(1, 1) * error.x() - jacobian(0, 1) * error.y()) / determinant,
                               (jacobian(0, 0) * error.y() - jacobian(1, 0) * error.x()) / determinant};
    guess -= step;
    if (step.squaredNorm() < 1e-26) break;
  }
  return guess;
}

double Intrinsics::MaxRadiusSquared() const {
  // d/dr of r(1 + k1 r2 + k2 r4 + k3 r6) = 1 + 3 k1 s + 5 k2 s2 + 7 k3 s3 with s = r2: its first positive
  // root.
  const auto slope = [&](double s) { return 1.0 + s * (3.0 * k1 + s * (5.0 * k2 + s * 7.0 * k3)); };
  constexpr double kWidest = 25.0;  // tan(79 degrees) squared: wider than any lens this model serves
  constexpr int kSteps = 500;
  double before = 0.0;
  for (int i = 1; i <= kSteps; ++i) {
    const double s = kWidest * i / kSteps;
    if (slope(s) <= 0.0) {
      double low = before;
      double high = s;
      for (int k = 0; k < 50; ++k) {
        const double middle = 0.5 * (low + high);
        (slope(middle) > 0.0 ? low : high) = middle;
      }
      return low;
    }
    before = s;
  }
  return std::numeric_limits<double>::infinity();
}

std::optional<Eigen::Vector2d> Intrinsics::Project(const Eigen::Vector3d& point_in_cam) const {
  if (point_in_cam.z() <= 1e-9) return std::nullopt;
  const Eigen::Vector2d normalised = point_in_cam.head<2>() / point_in_cam.z();
  const double s = normalised.squaredNorm();
  // The search for the largest radius is dear, and most rays lie where the slope cannot have fallen to 0 yet.
  const double min_slope =
      1.0 + s * (std::min(0.0, 3.0 * k1) + s * (std::min(0.0, 5.0 * k2) + s * std::min(0.0, 7.0 * k3)));
  if (min_slope <= 0.0 && s > MaxRadiusSquared()) return std::nullopt;
  return ProjectBeyondFold(point_in_cam);
}

Eigen::Vector2d Intrinsics::ProjectBeyondFold(const Eigen::Vector3d& point_in_cam) const {
  const Eigen::Vector2d bent = Distort(point_in_cam.head<2>() / point_in_cam.z());
  return {focal_x_px * bent.x() + center_x_px, focal_y_px * bent.y() + center_y_px};
}

Eigen::Vector3d Intrinsics::Unproject(const Eigen::Vector2d& pixel_in_image) const {
  const Eigen::Vector2d distorted{(pixel_in_image.x() - center_x_px) / focal_x_px,
                                  (pixel_in_image.y() - center_y_px) / focal_y_px};
  const Eigen::Vector2d straight = Undistort(distorted);
  return {straight.x(), straight.y(), 1.0};
}

}  // namespace skyquilt::camera
