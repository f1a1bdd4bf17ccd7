#include "core/pyramid/encode_tile.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/image/picture_codec.h"

namespace skyquilt::pyramid {
namespace {

using image::PictureFormat;
using image::RgbaImage;

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
  EXPECT_EQ(EncodeTile(WithHole(64), {})->format, PictureFormat::kPng);
  EXPECT_EQ(EncodeTile(WithHole(64), 0, 0, 32, {})->format, PictureFormat::kJpeg);
}

TEST(EncodeTile, GivesWebpStraightAlpha) {
  RgbaImage tile = WithHole(64);
  for (int x = 0; x < 64; ++x)
    std::fill_n(tile.Pixel(x, 0), 4, std::uint8_t{100});  // white, seen at 100 of 255
  const auto encoded = EncodeTile(tile, {.use_webp = true, .quality = 95});
  ASSERT_TRUE(encoded);
  EXPECT_EQ(encoded->format, PictureFormat::kWebp);
  const auto decoded =
      image::DecodePicture({reinterpret_cast<const char*>(encoded->bytes.data()), encoded->bytes.size()});
  ASSERT_TRUE(decoded);
  EXPECT_EQ(decoded->Pixel(30, 0)[3], 100);
  EXPECT_EQ(decoded->Pixel(63, 63)[3], 0);
  EXPECT_EQ(decoded->Pixel(10, 10)[3], 255);
  EXPECT_NEAR(decoded->Pixel(10, 10)[0], tile.Pixel(10, 10)[0], 12);
}

}  // namespace
}  // namespace skyquilt::pyramid
