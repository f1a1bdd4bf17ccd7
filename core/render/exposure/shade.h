// // Shade: what a photo's pixels are multiplied with, by where they lie in it: for each channel a polynomial
// in the place, and a spot where the sun stood behind the camera. ShadeGrid has it at the nodes of a grid,
// for whoever asks at many places. Values; any thread. Places are (x, y) from the middle of the lens, 1 at
// the distance of half the image's diagonal.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "core/camera/intrinsics.h"

namespace skyquilt::render {

constexpr int kShadeDegree = 6;
constexpr std::size_t kShadeTerms = (kShadeDegree + 1) * (kShadeDegree + 2) / 2;

// 1, x, y, x^2, xy, y^2, ...
std::array<double, kShadeTerms> ShadePowers(double x, double y);

// 1 in the middle, a quarter at `width` from there, nothing far away.
template <typename T>
T SpotShape(T distance_squared, T width) {
  const T part = width * width / (width * width + distance_squared);
  return part * part;
}

struct Shade {
  // By channel: what is added to 1; by term of ShadePowers.
  std::array<std::array<float, kShadeTerms>, 3> terms{};
  std::array<float, 2> spot_place{};
  float spot_width = 0.0f;               // 0: there is none
  std::array<float, 3> spot_log_gain{};  // in its middle

  bool IsEven() const;  // 1 everywhere
  std::array<double, 3> At(double x, double y) const;
};

class ShadeGrid {
 public:
  ShadeGrid(const Shade& shade, const camera::Intrinsics& lens);

  // At a pixel; beyond the image as at its edge. Bilinear: within 0.3 % of the polynomial.
  std::array<float, 3> At(float x_px, float y_px) const;

 private:
  static constexpr int kColumns = 25, kRows = 19;
  std::array<float, 3> SpotAt(float x_px, float y_px) const;

  float columns_per_px_, rows_per_px_;
  float spot_x_px_, spot_y_px_, spot_width_px_;
  std::array<float, 3> spot_log_gain_;
  std::vector<std::array<float, 3>> nodes_;  // row by row; empty where the shade is even
};

}  // namespace skyquilt::render
