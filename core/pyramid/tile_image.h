// RgbaImage: 8-bit RGBA with PREMULTIPLIED alpha, rows without padding, north row first. Premultiplied, so
// that averaging at the map's edge neither darkens nor bleeds. A value; any thread.
#pragma once

#include <cstdint>

#include "core/base/pixel_bytes.h"

namespace skyquilt::pyramid {

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
// Half the size, each pixel the mean of four: what GDAL's "average" overviews do, in the stored (sRGB)
// values.
RgbaImage Halve(const RgbaImage& image);
// Half the size, one pixel of each four as it is (the first that is covered): for colours that are codes.
RgbaImage EveryOther(const RgbaImage& image);
// Writes `quarter` at (x, y) of `image`.
void Paste(const RgbaImage& quarter, int x, int y, RgbaImage& image);

}  // namespace skyquilt::pyramid
