// RgbaImage: 8-bit RGBA, rows without padding, north row first. Whoever keeps one says whether its alpha is
// premultiplied, as that of a map being drawn is (averaging then neither darkens nor bleeds at its edge), or
// straight, as codecs have it. A value; any thread.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/base/pixel_bytes.h"

namespace skyquilt::image {

struct RgbaImage {
  int width_px = 0;
  int height_px = 0;
  PixelBytes rgba;

  static RgbaImage Transparent(int width_px, int height_px) {
    return {width_px, height_px, PixelBytes(static_cast<std::size_t>(width_px) * height_px * 4, 0)};
  }
  std::uint8_t* Pixel(int x, int y) { return rgba.data() + (static_cast<std::size_t>(y) * width_px + x) * 4; }
  const std::uint8_t* Pixel(int x, int y) const {
    return rgba.data() + (static_cast<std::size_t>(y) * width_px + x) * 4;
  }
};

// `count` pixels with straight instead of premultiplied alpha.
void StraightenAlpha(const std::uint8_t* premultiplied, int count, std::uint8_t* straight);

}  // namespace skyquilt::image
