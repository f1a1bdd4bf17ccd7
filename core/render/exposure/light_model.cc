#include "core/render/exposure/light_model.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace skyquilt::render {
namespace {

// Steps across a photo at which its shade is fitted: three for each degree.
constexpr int kSteps = 3 * kShadeDegree;
constexpr double kMaxShadeLog = 0.9;
constexpr double kFlattestTangent = 10.0;

template <std::size_t kSize>
double Dot(const std::array<double, kSize>& a, const std::array<double, kSize>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < kSize; ++i) sum += a[i] * b[i];
  return sum;
}

// The light's hot spot, where the photo sees it.
void AddSpot(const LightModel& light, const std::array<double, 3>& spot_share,
             const alignment::AlignedPhoto& photo, double px_per_unit, Shade& shade) {
  if (!light.directions.hot_spot) return;
  const Eigen::Vector2d& look = *light.directions.hot_spot;
  const auto pixel_of = [&](const Eigen::Vector2d& other) {
    return photo.intrinsics.Project(photo.cam_from_enu.rotation *
                                    Eigen::Vector3d(other.x(), other.y(), -1.0));
  };
  constexpr double kWidthStep = 0.05;
  const auto middle = pixel_of(look), east = pixel_of(look + Eigen::Vector2d(kWidthStep, 0.0)),
             north = pixel_of(look + Eigen::Vector2d(0.0, kWidthStep));
  if (!middle || !east || !north) return;
  Eigen::Matrix2d place_by_look;
  place_by_look << *east - *middle, *north - *middle;
  place_by_look /= kWidthStep * px_per_unit;
  if (!(std::abs(place_by_look.determinant()) > 1e-9)) return;
  const Eigen::Matrix2f look_by_place = place_by_look.inverse().cast<float>();
  const Eigen::Vector2d center{photo.intrinsics.center_x_px, photo.intrinsics.center_y_px};
  const Eigen::Vector2f place = ((*middle - center) / px_per_unit).cast<float>();
  shade.spot_place = {place.x(), place.y()};
  shade.look_by_place = {look_by_place(0, 0), look_by_place(0, 1), look_by_place(1, 0), look_by_place(1, 1)};
  for (std::size_t channel = 0; channel < 3; ++channel) {
    for (std::size_t hill = 0; hill < kSpotTerms; ++hill) {
      shade.spot_log_gains[channel][hill] = static_cast<float>(
          -spot_share[channel] * light.of_directions[channel][kSmoothDirectionTerms + hill]);
    }
  }
}

}  // namespace

CameraTerms CameraBasis(const Eigen::Vector2d& place) {
  const double x = place.x(), y = place.y(), r2 = x * x + y * y;
  return {r2, r2 * r2, r2 * r2 * r2, x, y, x * x - y * y, x * y, x * x * x, x * x * y, x * y * y, y * y * y};
}

DirectionTerms Directions::Basis(const Eigen::Vector2d& look) const {
  const double tangent = look.norm();
  const Eigen::Vector2d bounded =
      tangent > widest_look ? Eigen::Vector2d(look * (widest_look / tangent)) : look;
  const double e = bounded.x(), n = bounded.y(), e2 = e * e, n2 = n * n;
  DirectionTerms terms{e,      n,      e2,      e * n,      n2,      e2 * e,     e2 * n,
                       e * n2, n2 * n, e2 * e2, e2 * e * n, e2 * n2, e * n2 * n, n2 * n2};
  if (hot_spot) {
    const double distance_squared = (bounded - *hot_spot).squaredNorm();
    for (std::size_t hill = 0; hill < kSpotTerms; ++hill)
      terms[kSmoothDirectionTerms + hill] = SpotHill(distance_squared, kSpotReaches[hill]);
  }
  return terms;
}

Eigen::Vector2d LookOf(const Eigen::Vector3d& ray_in_enu) {
  const double sideways = ray_in_enu.head<2>().norm();
  if (sideways == 0.0) return Eigen::Vector2d::Zero();
  return ray_in_enu.head<2>() / std::max(-ray_in_enu.z(), sideways / kFlattestTangent);
}

Shade ShadeOf(const LightModel& light, const alignment::AlignedPhoto& photo,
              const std::array<double, 3>& spot_share) {
  Shade shade;
  const auto camera = light.cameras.find(photo.photo.camera_key);
  const bool has_light = light.of_directions != std::array<DirectionTerms, 3>{};
  if (camera == light.cameras.end() && !has_light) return shade;
  const camera::Intrinsics& lens = photo.intrinsics;
  const double px_per_unit = 0.5 * std::hypot(lens.width_px, lens.height_px);
  const Directions smooth{{}, light.directions.widest_look};
  constexpr int kPoints = (kSteps + 1) * (kSteps + 1);
  Eigen::MatrixXd powers(kPoints, static_cast<int>(kShadeTerms));
  Eigen::MatrixXd wanted(kPoints, 3);
  for (int point = 0; point < kPoints; ++point) {
    const int row = point / (kSteps + 1), column = point % (kSteps + 1);
    const Eigen::Vector2d pixel{(lens.width_px - 1.0) * column / kSteps,
                                (lens.height_px - 1.0) * row / kSteps};
    const Eigen::Vector2d place = (pixel - Eigen::Vector2d(lens.center_x_px, lens.center_y_px)) / px_per_unit;
    const auto at = ShadePowers(place.x(), place.y());
    for (std::size_t term = 0; term < kShadeTerms; ++term) powers(point, static_cast<int>(term)) = at[term];
    const Eigen::Vector3d ray = photo.cam_from_enu.rotation.conjugate() * lens.Unproject(pixel);
    const DirectionTerms direction = smooth.Basis(LookOf(ray));
    const CameraTerms in_camera = CameraBasis(place);
    for (std::size_t channel = 0; channel < 3; ++channel) {
      double brighter = Dot(light.of_directions[channel], direction);
      if (camera != light.cameras.end()) brighter += Dot(camera->second[channel], in_camera);
      wanted(point, static_cast<int>(channel)) =
          std::exp(-std::clamp(brighter, -kMaxShadeLog, kMaxShadeLog)) - 1.0;
    }
  }
  const Eigen::MatrixXd fitted = powers.colPivHouseholderQr().solve(wanted);
  for (std::size_t channel = 0; channel < 3; ++channel) {
    for (std::size_t term = 0; term < kShadeTerms; ++term) {
      const double value = fitted(static_cast<int>(term), static_cast<int>(channel));
      shade.terms[channel][term] = std::isfinite(value) ? static_cast<float>(value) : 0.0f;
    }
  }
  AddSpot(light, spot_share, photo, px_per_unit, shade);
  return shade;
}

}  // namespace skyquilt::render
