// Shade: what a photo's pixels are multiplied with, by where they lie in it: for each channel a polynomial
// in the place, and a hot spot where the sun stood behind the camera. ShadeGrid has it at the nodes of a
// grid, for whoever asks at many places. Values; any thread. Places are (x, y) from the middle of the lens, 1
// at the distance of half the image's diagonal.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "core/camera/intrinsics.h"

namespace skyquilt::render {

constexpr int kShadeDegree = 6;
constexpr std::size_t kShadeTerms = (kShadeDegree + 1) * (kShadeDegree + 2) / 2;

// 1, x, y, x^2, xy, y^2, ...
std::array<double, kShadeTerms> ShadePowers(double x, double y);

// A hot spot is a sum of round hills, so that it may be as sharp and as wide as the overlaps show. How far
// each reaches from the middle, as a tangent of direction; the widest first.
inline constexpr std::array kSpotReaches{0.32, 0.16, 0.08};
inline constexpr std::size_t kSpotTerms = kSpotReaches.size();

// 1 in the middle, 0 with level slope at `reach` and beyond.
template <typename T>
T SpotHill(T distance_squared, T reach) {
  const T left = std::max(T(0), T(1) - distance_squared / (reach * reach));
  return left * left;
}

struct Shade {
  // By channel: what is added to 1; by term of ShadePowers.
  std::array<std::array<float, kShadeTerms>, 3> terms{};
  std::array<float, 2> spot_place{};
  std::array<float, 4> look_by_place{};  // row by row: how the direction changes with the place, at the spot
  std::array<std::array<float, kSpotTerms>, 3> spot_log_gains{};  // by channel; of each hill's middle

  bool IsEven() const;  // 1 everywhere
  bool HasSpot() const;
  std::array<double, 3> At(double x, double y) const;
};

class ShadeGrid {
 public:
  ShadeGrid(const Shade& shade, const camera::Intrinsics& lens);

  // At a pixel; beyond the image as at its edge. Bilinear: within 0.3 % of the polynomial.
  std::array<float, 3> At(float x_px, float y_px) const;

 private:
  static constexpr int kColumns = 25, kRows = 19;

  float columns_per_px_, rows_per_px_;
  float spot_x_px_, spot_y_px_;
  std::array<float, 4> look_by_px_{};
  std::array<std::array<float, kSpotTerms>, 3> spot_log_gains_;
  bool has_spot_;
  std::vector<std::array<float, 3>> nodes_;  // row by row; empty where the shade is even
};

}  // namespace skyquilt::render
