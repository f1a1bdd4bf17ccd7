#include "core/surface/terrain/ground_model.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace skyquilt::surface {
namespace {

constexpr int kAcross = 200, kUp = 150;
constexpr double kCell = 0.5;

float HillAt(int column, int row) {
  return static_cast<float>(0.05 * kCell * column + 2.0 * std::sin(row * kCell / 15.0));
}

std::vector<float> Hill() {
  std::vector<float> heights;
  for (int row = 0; row < kUp; ++row) {
    for (int column = 0; column < kAcross; ++column) heights.push_back(HillAt(column, row));
  }
  return heights;
}

TEST(GroundUnder, LeavesBareGroundAsItIs) {
  const std::vector<float> hill = Hill();
  const GroundModel ground = GroundUnder(hill, kAcross, kUp, kCell);
  EXPECT_EQ(std::count(ground.is_ground.begin(), ground.is_ground.end(), 0), 0);
  EXPECT_EQ(ground.heights_m, hill);
}

TEST(GroundUnder, TakesHousesAndTreesAway) {
  std::vector<float> heights = Hill();
  const auto raise = [&](int left, int low, int right, int high, float by_m) {
    for (int row = low; row < high; ++row) {
      for (int column = left; column < right; ++column) {
        heights[static_cast<std::size_t>(row) * kAcross + column] = HillAt(column, row) + by_m;
      }
    }
  };
  raise(40, 40, 70, 60, 6.0f);
  raise(120, 80, 124, 84, 9.0f);
  raise(0, 100, 20, 120, 4.0f);  // at the border
  const GroundModel ground = GroundUnder(heights, kAcross, kUp, kCell);
  for (int row = 0; row < kUp; ++row) {
    for (int column = 0; column < kAcross; ++column) {
      const std::size_t cell = static_cast<std::size_t>(row) * kAcross + column;
      EXPECT_NEAR(ground.heights_m[cell], HillAt(column, row), 0.6) << column << " " << row;
      if (heights[cell] > HillAt(column, row) + 1.0f) {
        EXPECT_EQ(ground.is_ground[cell], 0);
      }
    }
  }
}

TEST(GroundUnder, TakesAnyGrid) {
  EXPECT_EQ(GroundUnder({3.0f}, 1, 1, 0.1).heights_m, std::vector<float>{3.0f});
  const GroundModel line = GroundUnder({1.0f, 1.0f, 9.0f, 1.0f, 1.0f, 1.0f, 1.0f}, 7, 1, 1.0);
  EXPECT_NEAR(line.heights_m[2], 1.0f, 1e-5);
}

}  // namespace
}  // namespace skyquilt::surface
