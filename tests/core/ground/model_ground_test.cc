#include "core/ground/model_ground.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace skyquilt::ground {
namespace {

// 60 m over ground of the given shape, points every `spacing_m` with some noise and wild outliers.
template <typename Shape>
alignment::AlignedFlight FlightOver(const Shape& height_at, double noise_m) {
  alignment::AlignedFlight flight;
  alignment::AlignedPhoto photo;
  photo.intrinsics = camera::Intrinsics::Centered(4000, 3000, 3000.0);
  photo.height_above_ground_m = 60.0;
  flight.photos.push_back(photo);
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0.0, noise_m);
  std::uniform_real_distribution<double> place(-100.0, 100.0);
  for (int i = 0; i < 6000; ++i) {
    const double east = place(random);
    const double north = place(random);
    const double z = i % 50 == 0 ? -56.0 : height_at(east, north) + noise(random);
    flight.tie_points_in_enu.emplace_back(east, north, z);
  }
  return flight;
}

TEST(ModelGround, ChoosesThePlaneOnFlatGroundAtTheHeightOfThePoints) {
  ModelGroundReport report;
  const GroundSurface surface = ModelGround(FlightOver([](double, double) { return 2.0; }, 0.05), report);
  EXPECT_TRUE(surface.IsPlane()) << report.reason;
  EXPECT_NEAR(surface.MeanHeight(), 2.0, 0.02);
  EXPECT_EQ(report.model, "plane");
}

TEST(ModelGround, FollowsHillsToAFewDecimetresInSpiteOfOutliers) {
  const auto hills = [](double east, double north) {
    return 5.0 * std::sin(east / 30.0) + 3.0 * std::cos(north / 25.0);
  };
  ModelGroundReport report;
  const GroundSurface surface = ModelGround(FlightOver(hills, 0.1), report);
  ASSERT_FALSE(surface.IsPlane()) << report.reason;
  double square = 0.0;
  int count = 0;
  for (double east = -95.0; east <= 95.0; east += 5.0) {
    for (double north = -95.0; north <= 95.0; north += 5.0) {
      const double miss = surface.HeightAt({east, north}) - hills(east, north);
      square += miss * miss;
      ++count;
    }
  }
  EXPECT_LT(std::sqrt(square / count), 0.2);
  EXPECT_GT(report.lowest_m, -12.0) << "an outlier made a pit";
}

TEST(ModelGround, ReturnsToTheMeanOutsideThePoints) {
  const auto slope = [](double east, double) { return 0.1 * east; };
  ModelGroundReport report;
  const GroundSurface surface = ModelGround(FlightOver(slope, 0.05), report);
  ASSERT_FALSE(surface.IsPlane());
  // Neither a curl upwards nor the slope carried on.
  EXPECT_LE(surface.HeightAt({400.0, 0.0}), 10.5);
  EXPECT_GE(surface.HeightAt({400.0, 0.0}), surface.MeanHeight() - 0.5);
  EXPECT_LE(surface.MaxHeight(), 10.5);
  EXPECT_GE(surface.MinHeight(), -10.5);
}

TEST(ModelGround, IsTheRecordedGroundWhereTooFewPointsAreKnown) {
  alignment::AlignedFlight flight;
  flight.ground_z_in_enu_m = 4.0;
  flight.tie_points_in_enu = {{0.0, 0.0, 30.0}, {1.0, 0.0, 31.0}};
  ModelGroundReport report;
  const GroundSurface surface = ModelGround(flight, report);
  EXPECT_TRUE(surface.IsPlane());
  EXPECT_EQ(surface.MeanHeight(), 4.0);
}

}  // namespace
}  // namespace skyquilt::ground
