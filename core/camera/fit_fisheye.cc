#include "core/camera/fit_fisheye.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/geo/solvers/dense_solvers.h"

namespace skyquilt::camera {
namespace {

constexpr double kWidestHalfViewRad = 75.0 * std::numbers::pi / 180.0;
constexpr int kSamples = 200;  // along the radius

// Pixels from the centre, in right angles' worth of pixels, of a ray so far off the axis.
double RhoOf(const FisheyeLens& fisheye, double off_axis_rad) {
  const double theta = 2.0 / std::numbers::pi * off_axis_rad;
  const auto& p = fisheye.polynomial;
  return p[0] + theta * (p[1] + theta * (p[2] + theta * (p[3] + theta * p[4])));
}

// How far off the axis the picture's furthest corner looks.
std::optional<double> HalfView(const FisheyeLens& fisheye, double reach) {
  double low = 0.0, before = 0.0;
  constexpr int kSteps = 300;
  for (int i = 1; i <= kSteps; ++i) {
    const double angle = kWidestHalfViewRad * i / kSteps;
    const double rho = RhoOf(fisheye, angle);
    if (!(rho > before)) return std::nullopt;  // folds back, or is not a number
    if (rho >= reach) return angle;
    before = rho;
    low = angle;
  }
  return RhoOf(fisheye, low) >= reach ? std::optional(low) : std::nullopt;
}

}  // namespace

std::optional<FittedLens> FitFisheye(const FisheyeLens& fisheye, int width_px, int height_px) {
  const double scale_x = fisheye.px_per_right_angle_x, scale_y = fisheye.px_per_right_angle_y;
  if (width_px <= 0 || height_px <= 0 || !(scale_x > 0.0) || !(scale_y > 0.0)) return std::nullopt;
  if (fisheye.polynomial[0] != 0.0) return std::nullopt;
  if (!(std::abs(fisheye.center_x_px / width_px - 0.5) < 0.1) ||
      !(std::abs(fisheye.center_y_px / height_px - 0.5) < 0.1))
    return std::nullopt;
  const double reach_x = std::max(fisheye.center_x_px, width_px - 1 - fisheye.center_x_px) / scale_x;
  const double reach_y = std::max(fisheye.center_y_px, height_px - 1 - fisheye.center_y_px) / scale_y;
  const auto half_view_rad = HalfView(fisheye, std::hypot(reach_x, reach_y));
  if (!half_view_rad) return std::nullopt;
  // rho = f r (1 + k1 r^2 + k2 r^4 + k3 r^6): linear in f and its products. Samples count by the ring of
  // picture that they stand for.
  Eigen::MatrixXd powers(kSamples, 4);
  Eigen::VectorXd rhos(kSamples);
  for (int i = 0; i < kSamples; ++i) {
    const double angle = *half_view_rad * (i + 0.5) / kSamples;
    const double r = std::tan(angle), rho = RhoOf(fisheye, angle), weight = std::sqrt(rho);
    for (int power = 0; power < 4; ++power) powers(i, power) = weight * std::pow(r, 2 * power + 1);
    rhos[i] = weight * rho;
  }
  const Eigen::Vector4d fitted = geo::SolveLeastSquares(powers, rhos);
  if (!fitted.allFinite() || !(fitted[0] > 0.0)) return std::nullopt;
  FittedLens result;
  Intrinsics& lens = result.lens;
  lens = Intrinsics::Centered(width_px, height_px, fitted[0] * scale_x);
  lens.focal_y_px = fitted[0] * scale_y;
  lens.center_x_px = fisheye.center_x_px;
  lens.center_y_px = fisheye.center_y_px;
  lens.k1 = fitted[1] / fitted[0];
  lens.k2 = fitted[2] / fitted[0];
  lens.k3 = fitted[3] / fitted[0];
  for (int i = 0; i <= kSamples; ++i) {
    const double angle = *half_view_rad * i / kSamples;
    const double bent = lens.Distort({std::tan(angle), 0.0}).x() * fitted[0];
    result.worst_px =
        std::max(result.worst_px, std::abs(bent - RhoOf(fisheye, angle)) * std::max(scale_x, scale_y));
  }
  return result;
}

}  // namespace skyquilt::camera
