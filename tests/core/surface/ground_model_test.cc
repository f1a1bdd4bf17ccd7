#include "core/surface/terrain/ground_model.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

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

TEST(GroundUnder, IsNotLedAstrayByPits) {
  std::vector<float> heights = Hill();
  for (int row = 20; row < kUp; row += 30) {
    for (int column = 10; column < kAcross; column += 25)
      heights[static_cast<std::size_t>(row) * kAcross + column] -= 8.0f;
  }
  const GroundModel ground = GroundUnder(heights, kAcross, kUp, kCell);
  for (int row = 0; row < kUp; ++row) {
    for (int column = 0; column < kAcross; ++column)
      EXPECT_NEAR(ground.heights_m[static_cast<std::size_t>(row) * kAcross + column], HillAt(column, row),
                  0.2);
  }
}

// Two cells of ground and one of plants, and so on: none has nothing but ground around it.
TEST(GroundUnder, KnowsTheGroundBetweenRowsOfPlants) {
  std::vector<float> heights = Hill();
  for (std::size_t cell = 0; cell < heights.size(); ++cell)
    heights[cell] += 100.0f + (cell % kAcross % 3 == 0 ? 0.8f : 0.0f);
  const GroundModel ground = GroundUnder(heights, kAcross, kUp, kCell);
  for (int row = 0; row < kUp; ++row) {
    for (int column = 0; column < kAcross; ++column)
      EXPECT_NEAR(ground.heights_m[static_cast<std::size_t>(row) * kAcross + column],
                  100.0f + HillAt(column, row), 0.3);
  }
}

TEST(GroundUnder, BridgesWhereThereIsNoHeight) {
  std::vector<float> heights = Hill();
  for (int row = 30; row < 40; ++row) {
    for (int column = 0; column < 12; ++column)
      heights[static_cast<std::size_t>(row) * kAcross + column] = std::numeric_limits<float>::quiet_NaN();
  }
  const GroundModel ground = GroundUnder(heights, kAcross, kUp, kCell);
  for (int row = 0; row < kUp; ++row) {
    for (int column = 0; column < kAcross; ++column) {
      const std::size_t cell = static_cast<std::size_t>(row) * kAcross + column;
      EXPECT_NEAR(ground.heights_m[cell], HillAt(column, row), 0.4) << column << " " << row;
      EXPECT_EQ(ground.is_ground[cell], std::isnan(heights[cell]) ? 0 : 1) << column << " " << row;
    }
  }
}

TEST(GroundUnder, TakesAnyGrid) {
  EXPECT_EQ(GroundUnder({3.0f}, 1, 1, 0.1).heights_m, std::vector<float>{3.0f});
  const GroundModel line = GroundUnder({1.0f, 1.0f, 9.0f, 1.0f, 1.0f, 1.0f, 1.0f}, 7, 1, 1.0);
  EXPECT_NEAR(line.heights_m[2], 1.0f, 1e-5);
  EXPECT_TRUE(std::isnan(GroundUnder({NAN, NAN}, 2, 1, 1.0).heights_m[1]));
}

}  // namespace
}  // namespace skyquilt::surface
