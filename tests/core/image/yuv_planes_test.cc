#include "core/image/yuv_planes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <random>
#include <vector>

namespace skyquilt::image {
namespace {

struct WithPlanes {
  int halves_x, halves_y;
  std::vector<std::uint8_t> y, u, v, alpha;

  explicit WithPlanes(const RgbaImage& image)
      : halves_x((image.width_px + 1) / 2),
        halves_y((image.height_px + 1) / 2),
        y(image.rgba.size() / 4),
        u(static_cast<std::size_t>(halves_x) * static_cast<std::size_t>(halves_y)),
        v(u.size()),
        alpha(y.size()) {
    FillYuvPlanes(image,
                  {y.data(), u.data(), v.data(), alpha.data(), image.width_px, halves_x, image.width_px});
  }
};

// ITU-R BT.601-7, luma from 16 to 235.
std::array<double, 3> YuvOf(double red, double green, double blue) {
  const double luma = 0.299 * red + 0.587 * green + 0.114 * blue;
  return {16.0 + 219.0 / 255.0 * luma, 128.0 + 224.0 / 255.0 * (blue - luma) / 1.772,
          128.0 + 224.0 / 255.0 * (red - luma) / 1.402};
}

TEST(FillYuvPlanes, IsTheStandardsMatrixForOpaquePixelsOfAnySize) {
  std::mt19937 random(3);
  for (const auto& [width_px, height_px] : {std::array{64, 32}, std::array{37, 5}, std::array{1, 1}}) {
    RgbaImage image = RgbaImage::Transparent(width_px, height_px);
    for (std::size_t i = 0; i < image.rgba.size(); ++i)
      image.rgba[i] = i % 4 == 3 ? 255 : static_cast<std::uint8_t>(random() % 256);
    const WithPlanes made(image);
    const auto colour = [&](int x, int y, int c) {
      return static_cast<double>(image.Pixel(std::min(x, width_px - 1), std::min(y, height_px - 1))[c]);
    };
    for (int y = 0; y < height_px; ++y) {
      for (int x = 0; x < width_px; ++x) {
        const auto wanted = YuvOf(colour(x, y, 0), colour(x, y, 1), colour(x, y, 2));
        EXPECT_NEAR(made.y[static_cast<std::size_t>(y * width_px + x)], wanted[0], 0.65);
      }
    }
    for (int y = 0; y < made.halves_y; ++y) {
      for (int x = 0; x < made.halves_x; ++x) {
        std::array<double, 3> mean{};
        for (int k = 0; k < 4; ++k) {
          for (int c = 0; c < 3; ++c)
            mean[static_cast<std::size_t>(c)] += 0.25 * colour(2 * x + k % 2, 2 * y + k / 2, c);
        }
        const auto wanted = YuvOf(mean[0], mean[1], mean[2]);
        const auto at = static_cast<std::size_t>(y * made.halves_x + x);
        EXPECT_NEAR(made.u[at], wanted[1], 0.65);
        EXPECT_NEAR(made.v[at], wanted[2], 0.65);
      }
    }
  }
}

TEST(FillYuvPlanes, TransparentPixelsDoNotBleedIntoTheEdgesColour) {
  RgbaImage image = RgbaImage::Transparent(4, 2);
  const std::array<std::uint8_t, 4> red{220, 20, 30, 255}, faint{20, 220, 30, 51};
  std::copy(red.begin(), red.end(), image.Pixel(1, 1));  // alone in its four
  std::copy(red.begin(), red.end(), image.Pixel(2, 0));
  std::copy(faint.begin(), faint.end(), image.Pixel(3, 0));
  const WithPlanes made(image);
  const auto alone = YuvOf(220, 20, 30), mixed = YuvOf((220 * 5 + 20) / 6.0, (20 * 5 + 220) / 6.0, 30);
  EXPECT_NEAR(made.u[0], alone[1], 0.6);
  EXPECT_NEAR(made.v[0], alone[2], 0.6);
  EXPECT_NEAR(made.u[1], mixed[1], 0.6);
  EXPECT_NEAR(made.v[1], mixed[2], 0.6);
  EXPECT_EQ(made.alpha, (std::vector<std::uint8_t>{0, 0, 255, 51, 0, 255, 0, 0}));
}

}  // namespace
}  // namespace skyquilt::image
