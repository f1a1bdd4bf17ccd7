#include "core/image/fringe_encoder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <random>

#include "core/image/picture_codec.h"
#include "core/image/yuv_planes.h"
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
