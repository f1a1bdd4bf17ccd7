#include "core/image/shrink/shrink_picture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>
#include <utility>
#include <vector>

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

struct Case {
  int width_px, height_px, channels, to_width_px, to_height_px;
};

std::vector<std::uint8_t> Noise(std::size_t bytes) {
  std::mt19937 random(7);
  std::vector<std::uint8_t> made(bytes);
  for (std::uint8_t& byte : made) byte = static_cast<std::uint8_t>(random() % 256);
  return made;
}

// Of [begin, begin + step) what lies in pixel `at`.
double Share(double begin, double step, int at) {
  return std::max(0.0, std::min(begin + step, at + 1.0) - std::max<double>(begin, at));
}

TEST(ShrinkByArea, EachPixelIsTheMeanOfItsArea) {
  constexpr int kPaddingBytes = 5;
  for (const Case& one : {Case{61, 33, 1, 50, 27}, Case{61, 33, 3, 12, 7}, Case{40, 20, 3, 20, 10},
                          Case{17, 5, 1, 1, 1}, Case{9, 9, 3, 9, 9}, Case{2, 1, 1, 1, 1}}) {
    const int row_bytes = one.width_px * one.channels + kPaddingBytes;
    const std::vector<std::uint8_t> picture = Noise(static_cast<std::size_t>(row_bytes * one.height_px));
    std::vector<std::uint8_t> small(
        static_cast<std::size_t>(one.to_width_px * one.to_height_px * one.channels));
    ShrinkByArea(
        {picture.data(), one.width_px, one.height_px, one.channels, static_cast<std::size_t>(row_bytes)},
        one.to_width_px, one.to_height_px, small.data());
    const double across = double(one.width_px) / one.to_width_px,
                 down = double(one.height_px) / one.to_height_px;
    for (int y = 0; y < one.to_height_px; ++y) {
      for (int x = 0; x < one.to_width_px * one.channels; ++x) {
        const int c = x % one.channels;
        double sum = 0.0;
        for (int from_y = 0; from_y < one.height_px; ++from_y) {
          for (int from_x = 0; from_x < one.width_px; ++from_x) {
            sum += Share(y * down, down, from_y) * Share(x / one.channels * across, across, from_x) *
                   picture[static_cast<std::size_t>(from_y * row_bytes + from_x * one.channels + c)];
          }
        }
        EXPECT_NEAR(small[static_cast<std::size_t>(y * one.to_width_px * one.channels + x)],
                    sum / (across * down), 0.502)
            << one.to_width_px << " x " << one.to_height_px << " at " << x << ", " << y;
      }
    }
  }
}

TEST(ShrinkByArea, WhiteStaysWhite) {
  const std::vector<std::uint8_t> white(std::size_t{1000} * 3 * 7, 255);
  std::vector<std::uint8_t> small(std::size_t{123} * 3 * 5);
  ShrinkByArea({white.data(), 1000, 7, 3, 3000}, 123, 5, small.data());
  EXPECT_EQ(std::count(small.begin(), small.end(), 255), static_cast<std::ptrdiff_t>(small.size()));
}

}  // namespace
}  // namespace skyquilt::image
