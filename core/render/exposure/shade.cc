#include "core/render/exposure/shade.h"

#include <algorithm>
#include <cmath>

namespace skyquilt::render {
namespace {

constexpr double kMinShade = 0.2, kMaxShade = 5.0;

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

}  // namespace skyquilt::render
