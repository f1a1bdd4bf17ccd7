// CubicSampler: reads a photo between its pixels, bicubic (Keys 1981 with a = -0.75, which keeps the
// gradients of the photo), to 1/64 of a pixel; beyond the photo's edge its last pixels go on. A view on the
// image, which must outlive it. Any thread; the same numbers whatever is asked for with it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/image/decoded_image.h"

namespace skyquilt::render {

// Red, green and blue in grey levels (overshooting a little); the fourth number means nothing.
using SampledPixel = std::array<float, 4>;

class CubicSampler {
 public:
  // Pixels around a place that a number there may depend on.
  static constexpr int kReachPx = 3;

  // left_px, top_px: where the image begins, of a photo of which it is a part; its edges count as the
  // photo's.
  explicit CubicSampler(const image::DecodedImage& image, int left_px = 0, int top_px = 0);

  // pixels[i] is the photo at (x[i], y[i]), pixel centres at whole numbers: places side by side are quickest.
  // Far outside (or not a number) reads the edge.
  void At(const float* x, const float* y, int count, SampledPixel* pixels) const;

 private:
  void AtEdge(int column, int row, int phase_x, int phase_y, SampledPixel& pixel) const;

  const std::uint8_t* rgb_;
  const int left_px_, top_px_, width_px_, height_px_;
  const std::ptrdiff_t stride_;
};

}  // namespace skyquilt::render
