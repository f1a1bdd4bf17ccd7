#include "core/render/blocks/cubic_sampler.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace skyquilt::render {
namespace {

image::DecodedImage Noise(int width_px, int height_px) {
  image::DecodedImage image;
  image.width_px = width_px, image.height_px = height_px;
  std::mt19937 random(11);
  for (int i = 0; i < 3 * width_px * height_px; ++i) image.rgb.push_back(static_cast<std::uint8_t>(random()));
  return image;
}

double Keys(double distance) {
  const double a = -0.75, t = std::abs(distance);
  if (t < 1.0) return ((a + 2.0) * t - (a + 3.0)) * t * t + 1.0;
  if (t < 2.0) return ((a * t - 5.0 * a) * t + 8.0 * a) * t - 4.0 * a;
  return 0.0;
}

// By the definition, at the 64th of a pixel that is nearest.
double Expected(const image::DecodedImage& image, double x, double y, int channel) {
  x = std::floor(64.0 * x + 0.5) / 64.0, y = std::floor(64.0 * y + 0.5) / 64.0;
  double sum = 0.0;
  for (int row = static_cast<int>(std::floor(y)) - 1; row <= std::floor(y) + 2; ++row) {
    for (int column = static_cast<int>(std::floor(x)) - 1; column <= std::floor(x) + 2; ++column) {
      const std::uint8_t value = image.Row(
          std::clamp(row, 0, image.height_px - 1))[3 * std::clamp(column, 0, image.width_px - 1) + channel];
      sum += Keys(x - column) * Keys(y - row) * value;
    }
  }
  return sum;
}

// Along a line.
void Sample(const CubicSampler& sampler, float x, float y, float step_x, float step_y, int count,
            SampledPixel* pixels) {
  std::vector<float> at_x, at_y;
  for (int i = 0; i < count; ++i) {
    at_x.push_back(x + static_cast<float>(i) * step_x);
    at_y.push_back(y + static_cast<float>(i) * step_y);
  }
  sampler.At(at_x.data(), at_y.data(), count, pixels);
}

TEST(CubicSampler, IsKeysInterpolationInTheMiddleAndAtTheEdges) {
  const image::DecodedImage image = Noise(40, 30);
  const CubicSampler sampler(image);
  std::mt19937 random(3);
  std::uniform_real_distribution<float> x_px(0.0F, 39.0F), y_px(0.0F, 29.0F), step_px(-0.8F, 0.8F);
  for (int line = 0; line < 300; ++line) {
    const float x = x_px(random), y = y_px(random), step_x = step_px(random), step_y = step_px(random);
    std::vector<SampledPixel> pixels(19);
    Sample(sampler, x, y, step_x, step_y, 19, pixels.data());
    for (int i = 0; i < 19; ++i) {
      const double at_x = x + static_cast<float>(i) * step_x, at_y = y + static_cast<float>(i) * step_y;
      if (at_x < 0.0 || at_y < 0.0 || at_x > 39.0 || at_y > 29.0) continue;
      // A 64th may be the next one in single precision.
      if (std::abs(std::remainder(64.0 * at_x - 0.5, 1.0)) < 1e-3 ||
          std::abs(std::remainder(64.0 * at_y - 0.5, 1.0)) < 1e-3)
        continue;
      for (int channel = 0; channel < 3; ++channel)
        EXPECT_NEAR(pixels[i][channel], Expected(image, at_x, at_y, channel), 0.06);
    }
  }
}

TEST(CubicSampler, APixelIsTheSameInARunOfAnyLength) {
  const image::DecodedImage image = Noise(60, 60);
  const CubicSampler sampler(image);
  std::mt19937 random(7);
  std::uniform_real_distribution<float> place_px(-5.0F, 64.0F), step_px(-1.2F, 1.2F);
  for (int line = 0; line < 500; ++line) {
    const float x = place_px(random), y = place_px(random), step_x = step_px(random),
                step_y = step_px(random);
    std::vector<SampledPixel> run(37);
    Sample(sampler, x, y, step_x, step_y, 37, run.data());
    for (int count = 1; count < 37; count += 5) {
      std::vector<SampledPixel> shorter(count);
      Sample(sampler, x, y, step_x, step_y, count, shorter.data());
      for (int i = 0; i < count; ++i) {
        for (int channel = 0; channel < 3; ++channel) ASSERT_EQ(shorter[i][channel], run[i][channel]);
      }
    }
  }
}

TEST(CubicSampler, FarOutsideAndNotANumberReadTheEdge) {
  image::DecodedImage image = Noise(20, 20);
  const CubicSampler sampler(image);
  for (const float far : {-1e30F, -500.0F, 500.0F, 1e30F, std::numeric_limits<float>::quiet_NaN()}) {
    std::array<SampledPixel, 16> pixels{};
    Sample(sampler, far, 5.0F, 0.0F, 0.0F, 16, pixels.data());
    const int column = far == 500.0F ? 19 : 0;  // all that is no place in a photo is its west
    for (int channel = 0; channel < 3; ++channel) {
      EXPECT_FLOAT_EQ(pixels[7][channel], image.Row(5)[3 * column + channel]);
    }
  }
}

}  // namespace
}  // namespace skyquilt::render
