#include "core/render/exposure/exposure.h"

#include <Eigen/LU>
#include <cmath>

#include "core/geo/solvers/dense_solvers.h"

namespace skyquilt::render {
namespace {

constexpr double kMinShade = 0.2, kMaxShade = 5.0;
// Steps across a photo at which its shade is fitted: three for each degree.
constexpr int kSteps = 3 * kShadeDegree;
constexpr double kMaxShadeLog = 0.9;
constexpr double kFlattestTangent = 10.0;

// What a hot spot multiplies with at (x, y) from its middle.
template <typename T>
std::array<T, 3> SpotGain(T x, T y, const std::array<float, 4>& look_by,
                          const std::array<std::array<float, kSpotTerms>, 3>& log_gains) {
  const T east = static_cast<T>(look_by[0]) * x + static_cast<T>(look_by[1]) * y;
  const T north = static_cast<T>(look_by[2]) * x + static_cast<T>(look_by[3]) * y;
  const T distance_squared = east * east + north * north;
  if (!(distance_squared < static_cast<T>(kSpotReaches[0] * kSpotReaches[0]))) return {1, 1, 1};
  std::array<T, 3> logs{};
  for (std::size_t hill = 0; hill < kSpotTerms; ++hill) {
    const T height = SpotHill(distance_squared, static_cast<T>(kSpotReaches[hill]));
    for (std::size_t channel = 0; channel < 3; ++channel)
      logs[channel] += static_cast<T>(log_gains[channel][hill]) * height;
  }
  return {std::exp(logs[0]), std::exp(logs[1]), std::exp(logs[2])};
}

}  // namespace

std::array<double, kShadeTerms> ShadePowers(double x, double y) {
  std::array<double, kShadeTerms> powers{};
  powers[0] = 1.0;
  std::size_t at = 1;
  for (int degree = 1; degree <= kShadeDegree; ++degree) {
    const std::size_t before = at - static_cast<std::size_t>(degree);
    for (int k = 0; k < degree; ++k, ++at) powers[at] = powers[before + static_cast<std::size_t>(k)] * x;
    powers[at] = powers[at - static_cast<std::size_t>(degree) - 1] * y;
    ++at;
  }
  return powers;
}

bool Shade::IsEven() const {
  return !HasSpot() && std::all_of(terms.begin(), terms.end(), [](const auto& channel) {
    return std::all_of(channel.begin(), channel.end(), [](float term) { return term == 0.0f; });
  });
}

bool Shade::HasSpot() const { return spot_log_gains != decltype(spot_log_gains){}; }

std::array<double, 3> Shade::At(double x, double y) const {
  const auto powers = ShadePowers(x, y);
  std::array<double, 3> value{1.0, 1.0, 1.0};
  for (std::size_t channel = 0; channel < value.size(); ++channel) {
    for (std::size_t term = 0; term < kShadeTerms; ++term) {
      value[channel] += static_cast<double>(terms[channel][term]) * powers[term];
    }
    value[channel] = std::clamp(value[channel], kMinShade, kMaxShade);
  }
  if (HasSpot()) {
    const auto spot = SpotGain(x - static_cast<double>(spot_place[0]), y - static_cast<double>(spot_place[1]),
                               look_by_place, spot_log_gains);
    for (std::size_t channel = 0; channel < value.size(); ++channel) value[channel] *= spot[channel];
  }
  return value;
}

ShadeGrid::ShadeGrid(const Shade& shade, const camera::Intrinsics& lens)
    : columns_per_px_(static_cast<float>(kColumns - 1) / static_cast<float>(std::max(1, lens.width_px - 1))),
      rows_per_px_(static_cast<float>(kRows - 1) / static_cast<float>(std::max(1, lens.height_px - 1))),
      spot_log_gains_(shade.spot_log_gains),
      has_spot_(shade.HasSpot()) {
  const double per_px = 2.0 / std::hypot(lens.width_px, lens.height_px);
  spot_x_px_ = static_cast<float>(lens.center_x_px + static_cast<double>(shade.spot_place[0]) / per_px);
  spot_y_px_ = static_cast<float>(lens.center_y_px + static_cast<double>(shade.spot_place[1]) / per_px);
  for (std::size_t i = 0; i < look_by_px_.size(); ++i)
    look_by_px_[i] = static_cast<float>(static_cast<double>(shade.look_by_place[i]) * per_px);
  if (shade.IsEven()) return;
  Shade smooth = shade;
  smooth.spot_log_gains = {};
  nodes_.reserve(static_cast<std::size_t>(kColumns) * kRows);
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      const double x = (column * (lens.width_px - 1.0) / (kColumns - 1) - lens.center_x_px) * per_px;
      const double y = (row * (lens.height_px - 1.0) / (kRows - 1) - lens.center_y_px) * per_px;
      const auto value = smooth.At(x, y);
      nodes_.push_back(
          {static_cast<float>(value[0]), static_cast<float>(value[1]), static_cast<float>(value[2])});
    }
  }
}

std::array<float, 3> ShadeGrid::At(float x_px, float y_px) const {
  if (nodes_.empty() || !std::isfinite(x_px) || !std::isfinite(y_px)) return {1.0f, 1.0f, 1.0f};
  const float x = std::clamp(x_px * columns_per_px_, 0.0f, static_cast<float>(kColumns - 1));
  const float y = std::clamp(y_px * rows_per_px_, 0.0f, static_cast<float>(kRows - 1));
  const int column = std::min(static_cast<int>(x), kColumns - 2),
            row = std::min(static_cast<int>(y), kRows - 2);
  const float u = x - static_cast<float>(column), v = y - static_cast<float>(row);
  const auto* north = nodes_.data() + static_cast<std::ptrdiff_t>(row) * kColumns + column;
  const auto* south = north + kColumns;
  std::array<float, 3> value{};
  for (std::size_t channel = 0; channel < value.size(); ++channel) {
    value[channel] = (1.0f - v) * ((1.0f - u) * north[0][channel] + u * north[1][channel]) +
                     v * ((1.0f - u) * south[0][channel] + u * south[1][channel]);
  }
  if (has_spot_) {  // too sharp for the grid
    const auto spot = SpotGain(x_px - spot_x_px_, y_px - spot_y_px_, look_by_px_, spot_log_gains_);
    for (std::size_t channel = 0; channel < value.size(); ++channel) value[channel] *= spot[channel];
  }
  return value;
}

namespace {

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
  const Eigen::MatrixXd fitted = geo::SolveLeastSquares(powers, wanted);
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
