#include "core/pyramid/tile_image.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <random>

namespace skyquilt::pyramid {
namespace {

// Also at the ends of a byte's range, where sums of four need more room than a byte.
TEST(Halve, EachByteIsTheRoundedMeanOfItsFour) {
  std::mt19937 random(5);
  for (const auto& [width_px, height_px] : {std::array{128, 6}, std::array{2, 2}, std::array{70, 4}}) {
    image::RgbaImage image = image::RgbaImage::Transparent(width_px, height_px);
    for (std::uint8_t& byte : image.rgba) {
      const auto drawn = static_cast<std::uint8_t>(random() % 256);
      byte = drawn < 80 ? std::uint8_t{255} : drawn < 120 ? std::uint8_t{0} : drawn;
    }
    const image::RgbaImage half = Halve(image);
    ASSERT_EQ(half.width_px, width_px / 2);
    ASSERT_EQ(half.height_px, height_px / 2);
    for (int y = 0; y < half.height_px; ++y) {
      for (int x = 0; x < half.width_px; ++x) {
        for (int c = 0; c < 4; ++c) {
          const int sum = image.Pixel(2 * x, 2 * y)[c] + image.Pixel(2 * x + 1, 2 * y)[c] +
                          image.Pixel(2 * x, 2 * y + 1)[c] + image.Pixel(2 * x + 1, 2 * y + 1)[c];
          ASSERT_EQ(half.Pixel(x, y)[c], (sum + 2) / 4) << x << " " << y << " " << c;
        }
      }
    }
  }
}

}  // namespace
}  // namespace skyquilt::pyramid
