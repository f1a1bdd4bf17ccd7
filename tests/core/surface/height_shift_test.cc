// How far heights of two flights lie off each other, on hills that are known, moved, raised and partly
// changed.
#include "core/surface/terrain/height_shift.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <vector>

namespace skyquilt::surface {
namespace {

constexpr int kShiftSide = 160;
constexpr double kShiftCellM = 0.5;

double HillsAt(double east_m, double north_m) {
  return 3.0 * std::sin(0.21 * east_m) * std::cos(0.17 * north_m) + 0.05 * east_m;
}

// Rows from the north; east and north of the middle.
std::vector<float> HeightsOf(const std::function<double(double, double)>& height_at) {
  std::vector<float> heights_m;
  for (int row = 0; row < kShiftSide; ++row) {
    for (int column = 0; column < kShiftSide; ++column)
      heights_m.push_back(static_cast<float>(height_at((column + 0.5 - kShiftSide / 2) * kShiftCellM,
                                                       (kShiftSide / 2 - row - 0.5) * kShiftCellM)));
  }
  return heights_m;
}

std::optional<HeightShift> Shift(const std::vector<float>& now, const std::vector<float>& then) {
  return ShiftBetween({kShiftSide, kShiftSide, kShiftCellM, now},
                      {kShiftSide, kShiftSide, kShiftCellM, then});
}

TEST(HeightShiftTest, IsFoundThoughAQuarterOfTheGroundHasChanged) {
  const auto now = HeightsOf([](double east_m, double north_m) {
    const double changed_m = east_m > 0 && north_m > 0 ? 4.0 : 0.0;
    return HillsAt(east_m - 2.3, north_m + 1.2) + 7.5 + changed_m;
  });
  const HeightShift shift = *Shift(now, HeightsOf(HillsAt));
  EXPECT_NEAR(shift.east_north_m.x(), 2.3, 0.1);
  EXPECT_NEAR(shift.east_north_m.y(), -1.2, 0.1);
  EXPECT_NEAR(shift.up_m, 7.5, 0.05);
  EXPECT_LT(*shift.sigma_m, 0.1);
}

TEST(HeightShiftTest, LevelGroundDoesNotTellSidewaysAndBentGroundIsDoubted) {
  const auto level = HeightsOf([](double, double) { return 100.0; });
  // Bent by half a metre over its length, as by an angle that a flight did not know.
  const auto bent = HeightsOf([](double east_m, double) { return 98.0 + east_m * east_m / 3200.0; });
  const HeightShift shift = *Shift(level, bent);
  EXPECT_EQ(shift.east_north_m, Eigen::Vector2d::Zero());
  EXPECT_GT(*shift.sigma_m, 0.05);
  EXPECT_LT(*shift.sigma_m, 0.3);
}

TEST(HeightShiftTest, WhatIsFartherOffThanIsTriedIsNotGuessedSideways) {
  const auto far = HeightsOf([](double east_m, double north_m) { return HillsAt(east_m - 11.0, north_m); });
  EXPECT_EQ(Shift(far, HeightsOf(HillsAt))->east_north_m, Eigen::Vector2d::Zero());
}

TEST(HeightShiftTest, OfWhatBothKnowAlone) {
  constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
  const auto west = HeightsOf([](double east_m, double) { return east_m < 0 ? 10.0 : kUnknown; });
  const auto east = HeightsOf([](double east_m, double) { return east_m < 0 ? kUnknown : 10.0; });
  const auto more = HeightsOf([](double east_m, double) { return east_m < 20 ? 8.0 : kUnknown; });
  EXPECT_FALSE(Shift(west, east));
  EXPECT_NEAR(Shift(west, more)->up_m, 2.0, 1e-6);
}

}  // namespace
}  // namespace skyquilt::surface
