#include "core/pyramid/tile_image.h"

#include <algorithm>
#include <cstring>

#include "core/base/check.h"

namespace skyquilt::pyramid {

image::RgbaImage Halve(const image::RgbaImage& image) {
  SKYQUILT_CHECK(image.width_px % 2 == 0 && image.height_px % 2 == 0, "only even images are halved");
  image::RgbaImage half = image::RgbaImage::Transparent(image.width_px / 2, image.height_px / 2);
  for (int y = 0; y < half.height_px; ++y) {
    const std::uint8_t* upper = image.Pixel(0, 2 * y);
    const std::uint8_t* lower = image.Pixel(0, 2 * y + 1);
    std::uint8_t* out = half.Pixel(0, y);
    for (int x = 0; x < half.width_px; ++x, upper += 8, lower += 8, out += 4) {
      for (int c = 0; c < 4; ++c) {
        out[c] = static_cast<std::uint8_t>((upper[c] + upper[c + 4] + lower[c] + lower[c + 4] + 2) >> 2);
      }
    }
  }
  return half;
}

image::RgbaImage EveryOther(const image::RgbaImage& image) {
  SKYQUILT_CHECK(image.width_px % 2 == 0 && image.height_px % 2 == 0, "only even images are halved");
  image::RgbaImage half = image::RgbaImage::Transparent(image.width_px / 2, image.height_px / 2);
  for (int y = 0; y < half.height_px; ++y) {
    for (int x = 0; x < half.width_px; ++x) {
      const std::uint8_t* upper = image.Pixel(2 * x, 2 * y);
      const std::uint8_t* lower = image.Pixel(2 * x, 2 * y + 1);
      for (const std::uint8_t* pixel : {upper, upper + 4, lower, lower + 4}) {
        if (pixel[3] == 0) continue;
        std::memcpy(half.Pixel(x, y), pixel, 4);
        break;
      }
    }
  }
  return half;
}

void Paste(const image::RgbaImage& quarter, int x, int y, image::RgbaImage& image) {
  SKYQUILT_CHECK(x + quarter.width_px <= image.width_px && y + quarter.height_px <= image.height_px,
                 "paste outside the image");
  for (int row = 0; row < quarter.height_px; ++row) {
    std::memcpy(image.Pixel(x, y + row), quarter.Pixel(0, row),
                static_cast<std::size_t>(quarter.width_px) * 4);
  }
}

}  // namespace skyquilt::pyramid
