#include "core/pyramid/encode_tile.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/image/fringe_encoder.h"
#include "core/image/picture_codec.h"
#include "tests/support/value_of.h"

namespace skyquilt::pyramid {
namespace {

using image::PictureFormat;
using image::RgbaImage;
using image::TileEncoding;

RgbaImage Covered(int size_px) {
  RgbaImage tile = RgbaImage::Transparent(size_px, size_px);
  for (int y = 0; y < size_px; ++y) {
    for (int x = 0; x < size_px; ++x) {
      std::uint8_t* pixel = tile.Pixel(x, y);
      for (int c = 0; c < 3; ++c) pixel[c] = static_cast<std::uint8_t>(3 * x + 2 * y + c);
      pixel[3] = 255;
    }
  }
  return tile;
}

RgbaImage WithHole(int size_px) {
  RgbaImage tile = Covered(size_px);
  std::fill_n(tile.Pixel(size_px - 1, size_px - 1), 4, std::uint8_t{0});
  return tile;
}

TEST(EncodeTile, IsJpegOnlyWhereEveryPixelIsCovered) {
  EXPECT_FALSE(EncodeTile(RgbaImage::Transparent(64, 64), {}));
  EXPECT_EQ(EncodeTile(Covered(64), {})->format, PictureFormat::kJpeg);
  EXPECT_EQ(EncodeTile(WithHole(64), {})->format, PictureFormat::kWebp);
  EXPECT_EQ(EncodeTile(WithHole(64), {.encoding = TileEncoding::kJpegPng})->format, PictureFormat::kPng);
  EXPECT_EQ(EncodeTile(WithHole(64), 0, 0, 32, {})->format, PictureFormat::kJpeg);
}

// Detail such as photographs have, cut by a ragged edge with a soft border.
RgbaImage Fringe(int size_px) {
  RgbaImage tile = RgbaImage::Transparent(size_px, size_px);
  std::uint32_t noise = 1;
  for (int y = 0; y < size_px; ++y) {
    for (int x = 0; x < size_px; ++x) {
      noise = noise * 1'664'525 + 1'013'904'223;
      const double inside = (x - 0.4 * size_px + 6.0 * std::sin(0.3 * y)) / 3.0;
      const int alpha = std::clamp(static_cast<int>(255.0 * inside), 0, 255);
      std::uint8_t* pixel = tile.Pixel(x, y);
      for (int c = 0; c < 3; ++c) {
        const double color =
            120.0 + 60.0 * std::sin(0.11 * x + c) * std::cos(0.07 * y) + static_cast<double>(noise >> 28);
        pixel[c] = static_cast<std::uint8_t>(color * alpha / 255.0 + 0.5);
      }
      pixel[3] = static_cast<std::uint8_t>(alpha);
    }
  }
  return tile;
}

RgbaImage Decoded(const std::vector<std::uint8_t>& bytes) {
  return *image::DecodePicture({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

TEST(EncodeTile, KeepsTheAlphaOfTheFringeExactlyAndItsColoursNearlyAsJpegDoes) {
  for (const int quality : {50, 85, 95}) {
    const RgbaImage tile = Fringe(256);
    const RgbaImage exact = Decoded(EncodeTile(tile, {TileEncoding::kJpegPng, quality})->bytes);
    const RgbaImage fringe = Decoded(EncodeTile(tile, {TileEncoding::kJpegWebp, quality})->bytes);
    const RgbaImage jpeg = Decoded(image::EncodeJpeg(image::RowsOf(exact), quality));
    double squares = 0.0, squares_of_jpeg = 0.0;
    for (std::size_t i = 0; i < exact.rgba.size(); i += 4) {
      ASSERT_EQ(fringe.rgba[i + 3], exact.rgba[i + 3]);
      if (exact.rgba[i + 3] != 255) continue;
      for (std::size_t c = i; c < i + 3; ++c) {
        squares += std::pow(fringe.rgba[c] - exact.rgba[c], 2);
        squares_of_jpeg += std::pow(jpeg.rgba[c] - exact.rgba[c], 2);
      }
    }
    EXPECT_LT(squares, 2.3 * squares_of_jpeg) << "quality " << quality;
  }
}

TEST(EncodeTile, TakesFewBytesForTheFringe) {
  const RgbaImage tile = Fringe(256);
  EXPECT_LT(4 * EncodeTile(tile, {TileEncoding::kJpegWebp})->bytes.size(),
            EncodeTile(tile, {TileEncoding::kJpegPng})->bytes.size());
}

TEST(EncodeFringe, MakesTheSameOfAPngAsOfThePixels) {
  const RgbaImage tile = Fringe(128);
  const RgbaImage png = Decoded(EncodeTile(tile, {TileEncoding::kJpegPng, 80})->bytes);
  EXPECT_EQ(image::EncodeFringe(png, 80), EncodeTile(tile, {TileEncoding::kJpegWebp, 80})->bytes);
}

TEST(EncodeFringe, TakesTheLeastQualityAndTheLeastTile) {
  EXPECT_EQ(Decoded(image::EncodeFringe(Fringe(16), 1)).width_px, 16);
  EXPECT_EQ(Decoded(image::EncodeFringe(RgbaImage::Transparent(1, 1), 100)).Pixel(0, 0)[3], 0);
}

TEST(EncodeTile, GivesWebpStraightAlpha) {
  RgbaImage tile = WithHole(64);
  for (int x = 0; x < 64; ++x)
    std::fill_n(tile.Pixel(x, 0), 4, std::uint8_t{100});  // white, seen at 100 of 255
  const auto encoded = test::ValueOf(EncodeTile(tile, {.encoding = TileEncoding::kWebp, .quality = 95}));
  EXPECT_EQ(encoded.format, PictureFormat::kWebp);
  const auto decoded = test::ValueOf(
      image::DecodePicture({reinterpret_cast<const char*>(encoded.bytes.data()), encoded.bytes.size()}));
  EXPECT_EQ(decoded.Pixel(30, 0)[3], 100);
  EXPECT_EQ(decoded.Pixel(63, 63)[3], 0);
  EXPECT_EQ(decoded.Pixel(10, 10)[3], 255);
  EXPECT_NEAR(decoded.Pixel(10, 10)[0], tile.Pixel(10, 10)[0], 12);
}

}  // namespace
}  // namespace skyquilt::pyramid
