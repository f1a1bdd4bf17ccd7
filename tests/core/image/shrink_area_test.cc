#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "core/image/shrink/shrink_picture.h"

namespace skyquilt::image {
namespace {

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
