#include "core/render/exposure/shade.h"

#include <algorithm>
#include <cmath>

namespace skyquilt::render {
namespace {

constexpr double kMinShade = 0.2, kMaxShade = 5.0;

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
  return spot_width == 0.0f && std::all_of(terms.begin(), terms.end(), [](const auto& channel) {
           return std::all_of(channel.begin(), channel.end(), [](float term) { return term == 0.0f; });
         });
}

std::array<double, 3> Shade::At(double x, double y) const {
  const auto powers = ShadePowers(x, y);
  std::array<double, 3> value{1.0, 1.0, 1.0};
  for (std::size_t channel = 0; channel < value.size(); ++channel) {
    for (std::size_t term = 0; term < kShadeTerms; ++term) {
      value[channel] += static_cast<double>(terms[channel][term]) * powers[term];
    }
    value[channel] = std::clamp(value[channel], kMinShade, kMaxShade);
  }
  if (spot_width > 0.0f) {
    const double spot = SpotShape(std::pow(x - static_cast<double>(spot_place[0]), 2) +
                                      std::pow(y - static_cast<double>(spot_place[1]), 2),
                                  static_cast<double>(spot_width));
    for (std::size_t channel = 0; channel < value.size(); ++channel)
      value[channel] *= std::exp(static_cast<double>(spot_log_gain[channel]) * spot);
  }
  return value;
}

ShadeGrid::ShadeGrid(const Shade& shade, const camera::Intrinsics& lens)
    : columns_per_px_(static_cast<float>(kColumns - 1) / static_cast<float>(std::max(1, lens.width_px - 1))),
      rows_per_px_(static_cast<float>(kRows - 1) / static_cast<float>(std::max(1, lens.height_px - 1))),
      spot_log_gain_(shade.spot_log_gain) {
  const double per_px = 2.0 / std::hypot(lens.width_px, lens.height_px);
  spot_x_px_ = static_cast<float>(lens.center_x_px + static_cast<double>(shade.spot_place[0]) / per_px);
  spot_y_px_ = static_cast<float>(lens.center_y_px + static_cast<double>(shade.spot_place[1]) / per_px);
  spot_width_px_ = static_cast<float>(static_cast<double>(shade.spot_width) / per_px);
  if (shade.IsEven()) return;
  Shade smooth = shade;
  smooth.spot_width = 0.0f;
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
  if (spot_width_px_ > 0.0f) {
    const std::array<float, 3> spot = SpotAt(x_px, y_px);
    for (std::size_t channel = 0; channel < value.size(); ++channel) value[channel] *= spot[channel];
  }
  return value;
}

// Too narrow for the grid.
std::array<float, 3> ShadeGrid::SpotAt(float x_px, float y_px) const {
  const float dx = x_px - spot_x_px_, dy = y_px - spot_y_px_;
  const float shape = SpotShape(dx * dx + dy * dy, spot_width_px_);
  return {std::exp(spot_log_gain_[0] * shape), std::exp(spot_log_gain_[1] * shape),
          std::exp(spot_log_gain_[2] * shape)};
}

}  // namespace skyquilt::render
