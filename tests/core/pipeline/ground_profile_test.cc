// Heights along lines against the surface that they were taken from.
#include "core/pipeline/report/ground_profile.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/value_of.h"

namespace skyquilt::pipeline {
namespace {

constexpr double kCellM = 2.0;

// A slope of a tenth to the east, from 0 to 20 m, around the origin.
ground::GroundSurface Slope() {
  std::vector<float> heights_m;
  for (int row = 0; row < 101; ++row) {
    for (int column = 0; column < 101; ++column)
      heights_m.push_back(static_cast<float>(0.1 * kCellM * column));
  }
  return ground::GroundSurface::Grid({-100.0, -100.0}, kCellM, 101, 101, heights_m, 10.0);
}

LocatedMap MapOf(const ground::GroundSurface& ground) {
  LocatedMap map;
  map.frame = geo::LocalFrame({.lat_deg = 47.3, .lon_deg = 8.5, .height_ellipsoid_m = 450.0});
  map.ground = ground;
  return map;
}

geo::LatLon At(const LocatedMap& map, double east_m, double north_m) {
  const geo::Wgs84 at = map.frame.Wgs84FromEnu({east_m, north_m, 0.0});
  return {at.lat_deg, at.lon_deg};
}

geo::LatLonBounds Around(const geo::LatLon& middle, double deg) {
  return {middle.lon_deg - deg, middle.lat_deg - deg, middle.lon_deg + deg, middle.lat_deg + deg};
}

TEST(ProfileGround, FollowsASlope) {
  const LocatedMap map = MapOf(Slope());
  const auto profile =
      ProfileGround(map, Around({47.3, 8.5}, 0.01), {At(map, -80, 0), At(map, 60, 0), At(map, 10, 0)});
  ASSERT_TRUE(profile) << profile.error().message;
  // At 450 m the ground is wider than the ellipsoid below it.
  const double shrink = 6.4e6 / (6.4e6 + 460.0);
  EXPECT_NEAR(profile->length_m, 190.0 * shrink, 0.01);
  EXPECT_NEAR(*profile->lowest_m, 452.0, 0.002);
  EXPECT_NEAR(*profile->highest_m, 466.0, 0.002);
  EXPECT_NEAR(profile->climb_m, 14.0, 0.002);
  EXPECT_NEAR(profile->descent_m, 5.0, 0.002);
  EXPECT_LE(profile->step_m, kCellM / 2 + 1e-9);
  EXPECT_EQ(profile->samples.front().distance_m, 0.0);
  EXPECT_NEAR(profile->samples.back().distance_m, profile->length_m, 1e-9);
  double before_m = -1.0;
  for (const ProfileSample& sample : profile->samples) {
    EXPECT_GT(sample.distance_m, before_m);
    EXPECT_LE(sample.distance_m - before_m, profile->step_m + 1.0);
    before_m = sample.distance_m;
    ASSERT_TRUE(sample.height_m);
    EXPECT_DOUBLE_EQ(*sample.height_m, GroundAt(map, sample.position).height_ellipsoid_m);
  }
}

TEST(ProfileGround, KnowsNothingBesideTheMapNorBesideTheGrid) {
  const LocatedMap map = MapOf(Slope());
  const std::vector<geo::LatLon> line = {At(map, -300, 0), At(map, 300, 0)};
  const auto by_grid = test::ValueOf(ProfileGround(map, Around({47.3, 8.5}, 0.01), line));
  for (const ProfileSample& sample : by_grid.samples) {
    const geo::Wgs84 at{sample.position.lat_deg, sample.position.lon_deg, 450.0};
    const double east_m = map.frame.EnuFromWgs84(at).x();
    if (std::abs(std::abs(east_m) - 100.0) < 0.1) continue;
    EXPECT_EQ(sample.height_m.has_value(), std::abs(east_m) < 100.0) << east_m;
  }
  EXPECT_NEAR(by_grid.climb_m, 20.0, 0.2);
  const geo::LatLon east = At(map, 50, 0);
  const auto by_map =
      ProfileGround(map, {8.5, 47.29, east.lon_deg, 47.31}, {At(map, -90, 0), At(map, 90, 0)});
  ASSERT_TRUE(by_map);
  EXPECT_NEAR(*by_map->lowest_m, 460.0, 0.15);
  EXPECT_NEAR(*by_map->highest_m, 465.0, 0.15);
  EXPECT_NEAR(by_map->climb_m, 5.0, 0.3);
  EXPECT_FALSE(by_map->samples.back().height_m);
}

// Two hills and a gap: what lies beyond the gap is no climb.
TEST(ProfileGround, AGapIsNeitherClimbNorDescent) {
  const LocatedMap map = MapOf(Slope());
  const auto profile = ProfileGround(map, Around({47.3, 8.5}, 0.01),
                                     {At(map, -90, 0), At(map, -90, 500), At(map, 90, 500), At(map, 90, 0)});
  ASSERT_TRUE(profile);
  EXPECT_NEAR(*profile->highest_m - *profile->lowest_m, 18.0, 0.01);
  EXPECT_LT(profile->climb_m + profile->descent_m, 0.1);
}

TEST(ProfileGround, APlaneIsLevelAndCostsNoMoreThanItsBound) {
  const LocatedMap map = MapOf(ground::GroundSurface::Plane(12.5));
  const auto profile =
      test::ValueOf(ProfileGround(map, Around({47.3, 8.5}, 0.01), {At(map, -100, 0), At(map, 100, 50)}));
  EXPECT_LE(profile.samples.size(), kMaxProfileSamples + 2);
  EXPECT_NEAR(*profile.lowest_m, 462.5, 0.01);
  EXPECT_NEAR(*profile.highest_m, 462.5, 0.01);
}

TEST(ProfileGround, SamplesAreBoundedHoweverFineTheGround) {
  const LocatedMap map =
      MapOf(ground::GroundSurface::Grid({-100.0, -100.0}, 0.01, 2, 2, {0.0F, 0.0F, 0.0F, 0.0F}, 0.0));
  std::vector<geo::LatLon> line;
  for (int i = 0; i < static_cast<int>(kMaxProfileCorners); ++i)
    line.push_back(At(map, i % 2 == 0 ? -90 : 90, 0.1 * i));
  const auto profile = test::ValueOf(ProfileGround(map, Around({47.3, 8.5}, 0.01), line));
  EXPECT_LE(profile.samples.size(), kMaxProfileSamples + 2 * kMaxProfileCorners);
  line.push_back(line.front());
  EXPECT_EQ(ProfileGround(map, Around({47.3, 8.5}, 0.01), line).error().code, ErrorCode::kUnprocessable);
}

TEST(ProfileGround, OneAndTheSamePlaceTwiceIsALineOfNoLength) {
  const LocatedMap map = MapOf(Slope());
  const auto profile =
      test::ValueOf(ProfileGround(map, Around({47.3, 8.5}, 0.01), {At(map, 0, 0), At(map, 0, 0)}));
  EXPECT_EQ(profile.length_m, 0.0);
  EXPECT_EQ(profile.samples.size(), 2u);
  EXPECT_EQ(profile.climb_m, 0.0);
}

TEST(ProfileGround, RefusesWhatIsNoLineAndWhatIsTooLong) {
  const LocatedMap map = MapOf(Slope());
  const geo::LatLonBounds bounds = Around({47.3, 8.5}, 0.01);
  EXPECT_EQ(ProfileGround(map, bounds, {}).error().code, ErrorCode::kUnprocessable);
  EXPECT_EQ(ProfileGround(map, bounds, {{47.3, 8.5}}).error().code, ErrorCode::kUnprocessable);
  const Error far = test::ErrorOf(ProfileGround(map, bounds, {{47.3, 8.5}, {48.3, 8.5}}));
  EXPECT_NE(far.message.find("100 km"), std::string::npos) << far.message;
}

TEST(ProfileGround, CrossesTheAntimeridianTheShortWay) {
  LocatedMap map = MapOf(Slope());
  map.frame = geo::LocalFrame({.lat_deg = -17.0, .lon_deg = 180.0, .height_ellipsoid_m = 0.0});
  const auto profile =
      ProfileGround(map, {179.99, -17.01, 180.01, -16.99}, {{-17.0, 179.9995}, {-17.0, -179.9995}});
  ASSERT_TRUE(profile) << profile.error().message;
  EXPECT_NEAR(profile->length_m, 106.5, 0.2);
  for (const ProfileSample& sample : profile->samples) {
    EXPECT_TRUE(sample.height_m);
    EXPECT_LE(std::abs(sample.position.lon_deg), 180.0);
  }
  EXPECT_NEAR(profile->climb_m, 10.65, 0.05);
}

}  // namespace
}  // namespace skyquilt::pipeline
