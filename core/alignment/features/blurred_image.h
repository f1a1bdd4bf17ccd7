// BlurredImage: a grey image in finer steps than bytes, and Blur: the same through a Gaussian, to 16 bits of
// weights; beyond the edge the last pixels go on. Values are below 2^15, sides at least one pixel, blurs up
// to five pixels (wider ones are cut off at sixteen). Pure; any thread; the same on every machine.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/pixel_bytes.h"

namespace skyquilt::alignment {

// Rows without padding, in 128ths of a grey level.
struct BlurredImage {
  int width_px = 0;
  int height_px = 0;
  std::vector<std::uint16_t, PixelAllocator<std::uint16_t>> values;

  const std::uint16_t* Row(int y) const { return values.data() + static_cast<std::size_t>(y) * width_px; }
  std::uint16_t* Row(int y) { return values.data() + static_cast<std::size_t>(y) * width_px; }
};

BlurredImage Blur(const BlurredImage& image, double sigma_px);

}  // namespace skyquilt::alignment
