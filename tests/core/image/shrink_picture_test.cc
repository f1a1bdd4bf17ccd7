#include "core/image/shrink/shrink_picture.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <utility>

namespace skyquilt::image {
namespace {

RgbaImage Filled(int width_px, int height_px, const std::array<std::uint8_t, 4>& colour) {
  RgbaImage image = RgbaImage::Transparent(width_px, height_px);
  for (std::size_t i = 0; i < image.rgba.size(); ++i) image.rgba[i] = colour[i % 4];
  return image;
}

std::array<int, 4> At(const RgbaImage& image, int x, int y) {
  const std::uint8_t* pixel = image.Pixel(x, y);
  return {pixel[0], pixel[1], pixel[2], pixel[3]};
}

TEST(ShrinkPicture, KeepsTheProportionsAndTheColour) {
  for (const auto& [width_px, height_px, small_px] :
       {std::array{512, 300, 188}, std::array{511, 512, 320}, std::array{512, 1, 1}}) {
    const RgbaImage small = ShrinkPicture(Filled(width_px, height_px, {10, 200, 30, 255}), 320);
    EXPECT_EQ(std::max(small.width_px, small.height_px), 320);
    EXPECT_EQ(small.height_px, small_px);
    for (int x = 0; x < small.width_px; ++x) {
      EXPECT_EQ(At(small, x, 0), (std::array{10, 200, 30, 255}));
      EXPECT_EQ(At(small, x, small.height_px - 1), (std::array{10, 200, 30, 255}));
    }
  }
}

TEST(ShrinkPicture, LeavesASmallPictureAsItIs) {
  const RgbaImage image = Filled(300, 200, {1, 2, 3, 4});
  EXPECT_EQ(ShrinkPicture(image, 320).rgba, image.rgba);
}

TEST(ShrinkPicture, TakesTheMeanByAreaAndLetsNothingTransparentColourIt) {
  // Three pixels become two: each covers one and a half.
  RgbaImage row = Filled(3, 1, {0, 0, 0, 255});
  row.Pixel(1, 0)[0] = 90;
  row.Pixel(2, 0)[0] = 240;
  const RgbaImage two = ShrinkPicture(row, 2);
  EXPECT_EQ(At(two, 0, 0), (std::array{30, 0, 0, 255}));
  EXPECT_EQ(At(two, 1, 0), (std::array{190, 0, 0, 255}));
  // A white pixel without alpha beside a red one.
  RgbaImage edge = Filled(2, 1, {255, 255, 255, 0});
  const std::array<std::uint8_t, 4> red = {200, 0, 0, 255};
  std::copy(red.begin(), red.end(), edge.Pixel(0, 0));
  EXPECT_EQ(At(ShrinkPicture(std::move(edge), 1), 0, 0), (std::array{200, 0, 0, 128}));
}

}  // namespace
}  // namespace skyquilt::image
