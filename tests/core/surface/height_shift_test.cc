// How far heights of two flights lie off each other, on hills and level ground that are known, moved, raised,
// partly changed and measured with noise.
#include "core/surface/terrain/height_shift.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <vector>

namespace skyquilt::surface {
namespace {

constexpr int kShiftSide = 160;
constexpr double kShiftCellM = 0.5, kNoiseM = 0.08;

double HillsAt(double east_m, double north_m) {
  return 3.0 * std::sin(0.21 * east_m) * std::cos(0.17 * north_m) + 0.05 * east_m;
}

// Rows from the north; east and north of the middle. Each flight has noise of its own.
std::vector<float> HeightsOf(const std::function<double(double, double)>& height_at, unsigned flight = 0) {
  std::mt19937 random(flight);
  std::normal_distribution<double> noise_m(0.0, kNoiseM);
  std::vector<float> heights_m;
  for (int row = 0; row < kShiftSide; ++row) {
    for (int column = 0; column < kShiftSide; ++column)
      heights_m.push_back(static_cast<float>(height_at((column + 0.5 - kShiftSide / 2) * kShiftCellM,
                                                       (kShiftSide / 2 - row - 0.5) * kShiftCellM) +
                                             (flight > 0 ? noise_m(random) : 0.0)));
  }
  return heights_m;
}

std::variant<HeightShift, ShiftFault> Compared(const std::vector<float>& now,
                                               const std::vector<float>& then) {
  return ShiftBetween({kShiftSide, kShiftSide, kShiftCellM, now},
                      {kShiftSide, kShiftSide, kShiftCellM, then});
}
HeightShift Shift(const std::vector<float>& now, const std::vector<float>& then) {
  return std::get<HeightShift>(Compared(now, then));
}
ShiftFault Fault(const std::vector<float>& now, const std::vector<float>& then) {
  return std::get<ShiftFault>(Compared(now, then));
}

TEST(HeightShiftTest, IsFoundThoughAThirdOfTheGroundHasRisen) {
  const auto now = HeightsOf(
      [](double east_m, double north_m) {
        return HillsAt(east_m - 2.3, north_m + 1.2) + 7.5 + (east_m > 13.0 ? 4.0 : 0.0);
      },
      1);
  const HeightShift shift = Shift(now, HeightsOf(HillsAt, 2));
  EXPECT_NEAR(shift.east_north_m->x(), 2.3, 0.1);
  EXPECT_NEAR(shift.east_north_m->y(), -1.2, 0.1);
  EXPECT_NEAR(shift.up_m, 7.5, 0.02) << "what has risen does not draw the level";
  EXPECT_LT(*shift.sigma_m, 0.05);
  EXPECT_NEAR(shift.alike_share, 0.66, 0.05);
}

TEST(HeightShiftTest, LevelGroundDoesNotTellSidewaysHoweverItsNoiseFits) {
  for (unsigned flight = 1; flight < 9; flight += 2) {
    const auto level = [](double, double) { return 100.0; };
    const HeightShift shift = Shift(HeightsOf(level, flight), HeightsOf(level, flight + 1));
    EXPECT_FALSE(shift.east_north_m) << flight;
    EXPECT_NEAR(shift.up_m, 0.0, 0.01);
    EXPECT_GT(shift.alike_share, 0.99);
  }
}

TEST(HeightShiftTest, AHeapOnLevelGroundTells) {
  const auto heap = [](double east_m, double north_m) {
    return std::max(0.0, 4.0 - 0.5 * std::hypot(east_m - 5.0, north_m));
  };
  const HeightShift still = Shift(HeightsOf(heap, 1), HeightsOf(heap, 2));
  EXPECT_LT(still.east_north_m.value_or(Eigen::Vector2d::Zero()).norm(), 0.3);
  const auto moved = [&](double east_m, double north_m) { return heap(east_m + 3.0, north_m); };
  EXPECT_NEAR(Shift(HeightsOf(moved, 1), HeightsOf(heap, 2)).east_north_m->x(), -3.0, 0.3);
}

TEST(HeightShiftTest, BentGroundIsDoubted) {
  // By half a metre over its length, as by an angle that a flight did not know.
  const auto bent = HeightsOf([](double east_m, double) { return 98.0 + east_m * east_m / 3200.0; });
  const HeightShift shift = Shift(HeightsOf([](double, double) { return 100.0; }), bent);
  EXPECT_GT(*shift.sigma_m, 0.05);
  EXPECT_LT(*shift.sigma_m, 0.3);
}

TEST(HeightShiftTest, WhatLiesFartherAsideThanIsTriedIsNotCompared) {
  const auto far = HeightsOf([](double east_m, double north_m) { return HillsAt(east_m - 8.0, north_m); }, 1);
  EXPECT_EQ(Fault(far, HeightsOf(HillsAt, 2)), ShiftFault::kTooFar);
}

TEST(HeightShiftTest, OfWhatBothKnowAlone) {
  constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
  const auto west = HeightsOf([](double east_m, double) { return east_m < 0 ? 10.0 : kUnknown; });
  const auto east = HeightsOf([](double east_m, double) { return east_m < 0 ? kUnknown : 10.0; });
  const auto more = HeightsOf([](double east_m, double) { return east_m < 20 ? 8.0 : kUnknown; });
  // Enough cells, too few patches to say how sure the level is.
  const auto rim = HeightsOf([](double east_m, double) { return east_m < -37 ? 8.0 : kUnknown; });
  EXPECT_EQ(Fault(west, east), ShiftFault::kTooLittle);
  EXPECT_EQ(Fault(west, rim), ShiftFault::kTooLittle);
  EXPECT_NEAR(Shift(west, more).up_m, 2.0, 1e-6);
}

}  // namespace
}  // namespace skyquilt::surface
