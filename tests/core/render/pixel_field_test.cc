#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "core/render/bands/band_cameras.h"

namespace skyquilt::render {
namespace {

constexpr int kWidthPx = 1280, kHeightPx = 960;

// What a polynomial of a few terms does not follow: a bend at the right edge, and one in a corner.
Eigen::Vector2d Bent(const Eigen::Vector2d& at) {
  const double x = at.x() / kWidthPx, y = at.y() / kHeightPx;
  return {1.2 * std::pow(x, 6) - 0.2, 0.8 * std::pow(x * y, 3) + 0.3 * std::sin(3.0 * y)};
}

std::vector<PixelMiss> Scattered(int count, double noise_px, int wrong_of_ten, double left_from = 0.0) {
  std::mt19937 generator(5);
  std::uniform_real_distribution<double> across(left_from, 1.0), down(0.0, 1.0), wrong(-4.0, 4.0);
  std::normal_distribution<double> noise(0.0, noise_px);
  std::vector<PixelMiss> misses;
  for (int i = 0; i < count; ++i) {
    PixelMiss miss{{across(generator) * kWidthPx, down(generator) * kHeightPx}, {}};
    miss.miss = Bent(miss.at) + Eigen::Vector2d(noise(generator), noise(generator));
    if (i % 10 < wrong_of_ten) miss.miss = {wrong(generator), wrong(generator)};
    misses.push_back(miss);
  }
  return misses;
}

double WorstPx(const PixelField& field, double from_x, double to_x) {
  double worst = 0.0;
  for (double x = from_x; x <= to_x; x += 0.05) {
    for (double y = 0.05; y < 1.0; y += 0.05) {
      const Eigen::Vector2d at(x * kWidthPx, y * kHeightPx);
      worst = std::max(worst, (field.At(at) - Bent(at)).norm());
    }
  }
  return worst;
}

TEST(PixelField, FollowsWhatMostMissesSay) {
  EXPECT_LT(WorstPx(FitPixelField(kWidthPx, kHeightPx, Scattered(4000, 0.2, 0)), 0.05, 0.96), 0.15);
  EXPECT_LT(WorstPx(FitPixelField(kWidthPx, kHeightPx, Scattered(4000, 0.2, 2)), 0.05, 0.96), 0.2);
}

TEST(PixelField, IsZeroWhereLittleIsKnown) {
  EXPECT_TRUE(PixelField().IsZero());
  EXPECT_EQ(PixelField().At({100.0, 100.0}), Eigen::Vector2d::Zero());
  EXPECT_TRUE(FitPixelField(kWidthPx, kHeightPx, {}).IsZero());
  EXPECT_TRUE(FitPixelField(kWidthPx, kHeightPx, Scattered(kFewestMisses - 1, 0.2, 0)).IsZero());
  EXPECT_FALSE(FitPixelField(kWidthPx, kHeightPx, Scattered(kFewestMisses, 0.2, 0)).IsZero());
}

TEST(PixelField, StaysSmallBeyondItsMisses) {
  const PixelField field = FitPixelField(kWidthPx, kHeightPx, Scattered(2000, 0.2, 0, 0.5));
  EXPECT_LT(WorstPx(field, 0.55, 0.96), 0.2);
  for (double y = 0.0; y <= 1.0; y += 0.1) EXPECT_LT(field.At({0.0, y * kHeightPx}).norm(), 1.5);
}

TEST(PixelField, OfOneAndTheSamePlaceIsFinite) {
  const std::vector<PixelMiss> misses(500, PixelMiss{{3.0, 3.0}, {0.5, -0.5}});
  const PixelField field = FitPixelField(kWidthPx, kHeightPx, misses);
  EXPECT_NEAR(field.At({3.0, 3.0}).x(), 0.5, 0.05);
  EXPECT_TRUE(field.At({1279.0, 959.0}).allFinite());
}

TEST(PixelField, GoesOnBeyondThePictureAsAtItsEdge) {
  const PixelField field = FitPixelField(kWidthPx, kHeightPx, Scattered(2000, 0.1, 0));
  EXPECT_EQ(field.At({-50.0, 300.0}), field.At({-0.5, 300.0}));
  EXPECT_EQ(field.At({5000.0, 5000.0}), field.At({kWidthPx - 0.5, kHeightPx - 0.5}));
  EXPECT_EQ(field.At({std::numeric_limits<double>::quiet_NaN(), 3.0}), Eigen::Vector2d::Zero());
}

}  // namespace
}  // namespace skyquilt::render
