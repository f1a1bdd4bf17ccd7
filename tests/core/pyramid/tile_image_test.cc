#include "core/pyramid/tile_image.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "core/pyramid/encode_tile.h"
#include "tests/support/value_of.h"

namespace skyquilt::pyramid {
namespace {

using image::RgbaImage;
using image::TileEncoding;

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

constexpr int kSidePx = 64;

// Smooth colours, premultiplied; the left quarter is open, the column beside it half covered.
RgbaImage Edge() {
  RgbaImage tile = RgbaImage::Transparent(kSidePx, kSidePx);
  for (int y = 0; y < kSidePx; ++y) {
    for (int x = kSidePx / 4; x < kSidePx; ++x) {
      std::uint8_t* pixel = tile.Pixel(x, y);
      pixel[3] = x == kSidePx / 4 ? 128 : 255;
      for (int c = 0; c < 3; ++c)
        pixel[c] = static_cast<std::uint8_t>((60 + 2 * y + 10 * c) * pixel[3] / 255);
    }
  }
  return tile;
}

RgbaImage Inside() {
  RgbaImage tile = RgbaImage::Transparent(kSidePx, kSidePx);
  for (int y = 0; y < kSidePx; ++y) {
    for (int x = 0; x < kSidePx; ++x) {
      std::uint8_t* pixel = tile.Pixel(x, y);
      for (int c = 0; c < 3; ++c) pixel[c] = static_cast<std::uint8_t>(40 + x + 2 * y);
      pixel[3] = 255;
    }
  }
  return tile;
}

double MeanDifference(const RgbaImage& a, const RgbaImage& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.rgba.size(); ++i) sum += std::abs(int{a.rgba[i]} - int{b.rgba[i]});
  return sum / static_cast<double>(a.rgba.size());
}

TEST(HalfOfTile, IsWhatThePixelsGiveButForWhatTheEncodingLost) {
  for (const TileEncoding encoding : {TileEncoding::kJpegWebp, TileEncoding::kJpegPng, TileEncoding::kWebp}) {
    for (const RgbaImage& tile : {Edge(), Inside()}) {
      const auto encoded = test::ValueOf(EncodeTile(tile, {.encoding = encoding, .quality = 90}));
      const auto half = test::ValueOf(HalfOfTile(encoded.bytes, kSidePx));
      const RgbaImage exact = Halve(tile);
      ASSERT_EQ(half.width_px, exact.width_px);
      EXPECT_LT(MeanDifference(half, exact), 3.0);
      for (int y = 0; y < exact.height_px; ++y) {
        for (int x = 0; x < exact.width_px; ++x) EXPECT_EQ(half.Pixel(x, y)[3], exact.Pixel(x, y)[3]);
      }
    }
  }
}

TEST(HalfOfTile, RefusesWhatIsDamagedOrOfAnotherSize) {
  const auto encoded = test::ValueOf(EncodeTile(Inside(), {}));
  EXPECT_EQ(HalfOfTile(encoded.bytes, 2 * kSidePx).error().code, ErrorCode::kCorrupt);
  EXPECT_EQ(HalfOfTile({}, kSidePx).error().code, ErrorCode::kCorrupt);
  EXPECT_FALSE(HalfOfTile(std::span(encoded.bytes).first(30), kSidePx));
}

}  // namespace
}  // namespace skyquilt::pyramid
