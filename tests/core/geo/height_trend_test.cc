#include "core/geo/height_trend.h"

#include <gtest/gtest.h>

#include <random>

namespace skyquilt::geo {
namespace {

template <typename Shape>
std::vector<Eigen::Vector3d> PointsOn(const Shape& height_at, double width_m, double height_m) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-0.5, 0.5);
  std::normal_distribution<double> noise(0.0, 0.02);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 4000; ++i) {
    const double east = 500.0 + width_m * place(random), north = -300.0 + height_m * place(random);
    // One in ten is a treetop.
    points.emplace_back(east, north, height_at(east, north) + noise(random) + (i % 10 == 0 ? 8.0 : 0.0));
  }
  return points;
}

TEST(HeightTrend, IsLevelAtTheMedianOfFewPointsAndZeroOfNone) {
  EXPECT_EQ(FitHeightTrend({}, 10.0).At({3.0, 4.0}), 0.0);
  const HeightTrend few = FitHeightTrend({{0.0, 0.0, 1.0}, {50.0, 0.0, 2.0}, {90.0, 0.0, 7.0}}, 10.0);
  EXPECT_EQ(few.shape, HeightTrend::Shape::kLevel);
  EXPECT_EQ(few.At({1000.0, 0.0}), 2.0);
}

TEST(HeightTrend, FindsAPlaneUnderTrees) {
  const auto slope = [](double east, double north) { return 3.0 + 0.05 * east - 0.02 * north; };
  const HeightTrend trend = FitHeightTrend(PointsOn(slope, 200.0, 150.0), 10.0);
  EXPECT_EQ(trend.shape, HeightTrend::Shape::kPlane);
  for (const Eigen::Vector2d& at : {Eigen::Vector2d(500.0, -300.0), {650.0, -200.0}, {350.0, -420.0}}) {
    EXPECT_NEAR(trend.At(at), slope(at.x(), at.y()), 0.1);
  }
}

TEST(HeightTrend, FindsATiltedBowlEvenUnderASingleFlightLine) {
  const auto bowl = [](double east, double north) {
    return 1.0 + 0.01 * east +
           2e-4 * (Eigen::Vector2d(east, north) - Eigen::Vector2d(480.0, -310.0)).squaredNorm();
  };
  for (const double across_m : {150.0, 60.0}) {
    const HeightTrend trend = FitHeightTrend(PointsOn(bowl, 200.0, across_m), 10.0);
    EXPECT_EQ(trend.shape, HeightTrend::Shape::kBowl);
    EXPECT_NEAR(trend.bowl_per_m, 2e-4, 2e-5);
    EXPECT_NEAR(trend.At({630.0, -300.0}), bowl(630.0, -300.0), 0.3) << across_m;
  }
}

TEST(HeightTrend, TakesHillsForNeitherASlopeNorABowl) {
  const auto hills = [](double east, double north) {
    return 5.0 * std::sin(east / 20.0) * std::cos(north / 15.0);
  };
  EXPECT_EQ(FitHeightTrend(PointsOn(hills, 250.0, 250.0), 10.0).shape, HeightTrend::Shape::kLevel);
}

TEST(CellMedians, GivesTheMiddleOfACellItsMedianHeight) {
  std::vector<Eigen::Vector3d> points{{1.0, 1.0, 5.0}, {2.0, 2.0, 1.0}, {3.0, 3.0, 9.0}, {31.0, 2.0, 4.0}};
  const std::vector<Eigen::Vector3d> cells = CellMedians(points, 10.0);
  ASSERT_EQ(cells.size(), 2U);
  EXPECT_EQ(cells[0], Eigen::Vector3d(2.0, 2.0, 5.0));
  EXPECT_EQ(cells[1], Eigen::Vector3d(31.0, 2.0, 4.0));
}

}  // namespace
}  // namespace skyquilt::geo
