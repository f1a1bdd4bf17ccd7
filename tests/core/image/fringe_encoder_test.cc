#include "core/image/fringe_encoder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>

#include "core/image/picture_codec.h"
#include "tests/support/bytes_of.h"

namespace skyquilt::image {
namespace {

using test::Text;

std::uint32_t Next(std::uint32_t& state) { return state = state * 1'664'525 + 1'013'904'223; }

RgbaImage Drawn(int width_px, int height_px, const std::function<int(int, int)>& alpha) {
  RgbaImage image = RgbaImage::Transparent(width_px, height_px);
  for (int y = 0; y < height_px; ++y) {
    for (int x = 0; x < width_px; ++x) {
      std::uint8_t* pixel = image.Pixel(x, y);
      for (int c = 0; c < 3; ++c)
        pixel[c] = static_cast<std::uint8_t>(128 + 90 * std::sin(0.09 * x + c) * std::cos(0.05 * y));
      pixel[3] = static_cast<std::uint8_t>(alpha(x, y));
    }
  }
  return image;
}

// Every way in which alpha may lie: nothing, all, edges in all directions, soft ones, single pixels, noise.
TEST(EncodeFringeWebp, KeepsAnyAlphaExactly) {
  std::uint32_t state = 7;
  const std::vector<std::function<int(int, int)>> alphas{
      [](int, int) { return 0; },
      [](int, int) { return 255; },
      [](int, int) { return 7; },
      [](int x, int) { return x < 3 ? 255 : 0; },
      [](int, int y) { return y < 3 ? 255 : 0; },
      [](int x, int y) { return 3 * x + 2 * y > 60 ? 255 : 0; },
      [](int x, int y) { return (x + y) % 2 * 255; },
      [](int x, int y) { return std::clamp(8 * (x - y), 0, 255); },
      [](int x, int y) { return x == 5 && y == 9 ? 1 : 0; },
      [&](int, int) { return static_cast<int>(Next(state) >> 24); },
      // Some values far more often than others: words of all lengths.
      [&](int, int) { return static_cast<int>(std::countl_zero(Next(state) | 1)) * 9; },
  };
  for (const auto& [width_px, height_px] :
       {std::pair{1, 1}, {1, 40}, {40, 1}, {17, 33}, {64, 64}, {256, 256}}) {
    for (std::size_t i = 0; i < alphas.size(); ++i) {
      const RgbaImage image = Drawn(width_px, height_px, alphas[i]);
      const auto webp = EncodeFringeWebp(image, 80.0F);
      EXPECT_EQ(PictureFormatOf(Text(webp)), PictureFormat::kWebp);
      EXPECT_TRUE(IsWebpWithAlpha(Text(webp)));
      const auto decoded = DecodePicture(Text(webp));
      ASSERT_TRUE(decoded) << width_px << " x " << height_px << ", alpha " << i;
      ASSERT_EQ(decoded->width_px, width_px);
      ASSERT_EQ(decoded->height_px, height_px);
      for (std::size_t at = 3; at < image.rgba.size(); at += 4)
        ASSERT_EQ(decoded->rgba[at], image.rgba[at]) << width_px << " x " << height_px << ", alpha " << i;
    }
  }
}

TEST(EncodeFringeWebp, KeepsColoursNearAndEdgesClean) {
  // Black where nothing is, as maps have it, must not bleed into what is there.
  RgbaImage image = Drawn(256, 256, [](int x, int y) { return 3 * x + 2 * y > 500 ? 255 : 0; });
  for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
    if (image.rgba[i + 3] == 0) std::fill_n(&image.rgba[i], 3, std::uint8_t{0});
  }
  const auto decoded = DecodePicture(Text(EncodeFringeWebp(image, 85.0F)));
  ASSERT_TRUE(decoded);
  double squares = 0.0;
  int covered = 0, worst = 0;
  for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
    if (image.rgba[i + 3] == 0) continue;
    ++covered;
    for (std::size_t c = i; c < i + 3; ++c) {
      const int off = decoded->rgba[c] - image.rgba[c];
      squares += off * off;
      worst = std::max(worst, std::abs(off));
    }
  }
  EXPECT_LT(std::sqrt(squares / (3.0 * covered)), 3.0);
  EXPECT_LT(worst, 40);
}

TEST(EncodeFringeWebp, TakesLittleForLongEdges) {
  const auto mask = [](int x, int y) { return 3 * x + 2 * y > 500 ? 255 : 0; };
  const RgbaImage grey = [&] {
    RgbaImage image = Drawn(512, 512, mask);
    for (std::size_t i = 0; i < image.rgba.size(); i += 4) std::fill_n(&image.rgba[i], 3, std::uint8_t{90});
    return image;
  }();
  EXPECT_LT(EncodeFringeWebp(grey, 80.0F).size(), 2'500u);
}

TEST(EncodeFringeWebp, SaysWhatItCannotTake) {
  EXPECT_THROW(EncodeFringeWebp(RgbaImage::Transparent(8, 8), 101.0F), std::runtime_error);
}

}  // namespace
}  // namespace skyquilt::image
