// Pictures as a sensor stored them, decoded: of three channels, with a box of its pixels and a part of it,
// and of one channel. Values; any thread.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/pixel_bytes.h"

namespace skyquilt::image {

// 8-bit RGB, rows without padding, first row on top, as the sensor stored it (EXIF orientation not applied:
// the recorded angles belong to the sensor).
struct DecodedImage {
  int width_px = 0;
  int height_px = 0;
  PixelBytes rgb;

  const std::uint8_t* Row(int y) const { return rgb.data() + static_cast<std::size_t>(y) * width_px * 3; }
};

// Pixels from left to right - 1 and from top to bottom - 1; none where those are less.
struct PixelBox {
  int left = 0, top = 0, right = 0, bottom = 0;

  bool IsEmpty() const { return right <= left || bottom <= top; }
  bool Contains(const PixelBox& other) const {
    return left <= other.left && top <= other.top && right >= other.right && bottom >= other.bottom;
  }
  // The smallest around both.
  PixelBox With(const PixelBox& other) const {
    if (IsEmpty()) return other;
    if (other.IsEmpty()) return *this;
    return {std::min(left, other.left), std::min(top, other.top), std::max(right, other.right),
            std::max(bottom, other.bottom)};
  }
  PixelBox Within(const PixelBox& other) const {
    return {std::max(left, other.left), std::max(top, other.top), std::min(right, other.right),
            std::min(bottom, other.bottom)};
  }
  PixelBox Grown(int by) const { return {left - by, top - by, right + by, bottom + by}; }
};

// A rectangle of a picture.
struct DecodedPart {
  DecodedImage image;
  int left_px = 0, top_px = 0;  // of the picture's pixels, where it begins
};

// Pictures of one channel: as a sensor stored it, 16 bits a pixel, and as numbers. Rows without padding,
// first row on top, as the sensor stored it. Values; any thread.
struct SampleImage {
  int width_px = 0;
  int height_px = 0;
  std::vector<std::uint16_t> samples;  // 8-bit pictures brought to 16 bits
};

struct FloatImage {
  int width_px = 0;
  int height_px = 0;
  std::vector<float> values;
};

}  // namespace skyquilt::image
