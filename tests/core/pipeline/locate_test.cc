// Photos and points against simulated truth: no tolerance but that of arithmetic.
#include "core/pipeline/report/locate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/support/value_of.h"

namespace skyquilt::pipeline {
namespace {

// A camera with a bent lens that looks down, turned and tilted a little.
alignment::AlignedPhoto PhotoAt(const std::string& name, double east_m, double north_m, double tilt_rad) {
  alignment::AlignedPhoto photo;
  photo.photo.name = name;
  photo.intrinsics = camera::Intrinsics::Centered(4000, 3000, 3200.0);
  photo.intrinsics.k1 = -0.08;
  photo.intrinsics.k2 = 0.01;
  const Eigen::Quaterniond down(Eigen::AngleAxisd(geo::kPi, Eigen::Vector3d::UnitX()));
  const Eigen::Quaterniond turned(Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ()));
  const Eigen::Quaterniond tilted(Eigen::AngleAxisd(tilt_rad, Eigen::Vector3d::UnitX()));
  photo.cam_from_enu =
      geo::Rigid3::FromRotationAndTargetOrigin(tilted * turned * down, {east_m, north_m, 120.0});
  photo.placement = alignment::Placement::kAligned;
  photo.error_radius_m = 0.5;
  return photo;
}

alignment::AlignedFlight Flight() {
  alignment::AlignedFlight flight;
  flight.frame = geo::LocalFrame({.lat_deg = 47.3, .lon_deg = 8.5, .height_ellipsoid_m = 450.0});
  for (int i = 0; i < 5; ++i)
    flight.photos.push_back(PhotoAt("p" + std::to_string(i), 30.0 * i, 10.0 * i, 0.1 * i));
  return flight;
}

ground::GroundSurface Hills() {
  std::vector<float> heights;
  for (int row = 0; row < 60; ++row) {
    for (int column = 0; column < 60; ++column) {
      heights.push_back(static_cast<float>(10.0 * std::sin(0.2 * column) * std::cos(0.15 * row)));
    }
  }
  return ground::GroundSurface::Grid({-200.0, -200.0}, 10.0, 60, 60, heights, 0.0);
}

LocatedMap Read(const ground::GroundSurface& ground) {
  const Result<LocatedMap> map = ParseLocateJson(LocateJson(Flight(), ground));
  EXPECT_TRUE(map);
  return *map;
}

class LocateTest : public testing::TestWithParam<bool> {
 protected:
  ground::GroundSurface Ground() const { return GetParam() ? Hills() : ground::GroundSurface::Plane(12.5); }
};

TEST_P(LocateTest, APixelsGroundIsSeenAtThatPixel) {
  const LocatedMap map = Read(Ground());
  std::mt19937 random(5);
  std::uniform_real_distribution<double> x(0.0, 3999.0);
  std::uniform_real_distribution<double> y(0.0, 2999.0);
  for (int i = 0; i < 500; ++i) {
    const std::string name = "p" + std::to_string(i % 5);
    const Eigen::Vector2d pixel(x(random), y(random));
    const auto point = test::ValueOf(GroundAtPixel(map, name, pixel));
    EXPECT_GE(point.sigma_m.value_or(0.0), 0.5);
    bool is_seen = false;
    for (const Sighting& sighting : PhotosAtPoint(map, point.position)) {
      if (sighting.photo != name) continue;
      is_seen = true;
      EXPECT_LT((sighting.pixel_in_image - pixel).norm(), 1e-3);
    }
    EXPECT_TRUE(is_seen);
  }
}

TEST_P(LocateTest, TheTruePointIsWhereThePhotoShowsIt) {
  const ground::GroundSurface ground = Ground();
  const LocatedMap map = Read(ground);
  const alignment::AlignedFlight flight = Flight();
  for (const alignment::AlignedPhoto& photo : flight.photos) {
    // Straight below the camera, and somewhat aside.
    for (const Eigen::Vector2d& aside :
         {Eigen::Vector2d(0, 0), Eigen::Vector2d(14, -9), Eigen::Vector2d(-20, 11)}) {
      const Eigen::Vector2d at = photo.cam_from_enu.TargetOriginInSource().head<2>() + aside;
      const Eigen::Vector3d truth(at.x(), at.y(), ground.HeightAt(at));
      const auto pixel = test::ValueOf(photo.intrinsics.Project(photo.cam_from_enu * truth));
      if (!photo.intrinsics.IsInImage(pixel)) continue;
      const auto point = test::ValueOf(GroundAtPixel(map, photo.photo.name, pixel));
      const Eigen::Vector3d found =
          flight.frame.EnuFromWgs84({point.position.lat_deg, point.position.lon_deg,
                                     flight.frame.Wgs84FromEnu(truth).height_ellipsoid_m});
      EXPECT_LT((found - truth).norm(), 1e-4);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Grounds, LocateTest, testing::Bool());

TEST(Locate, TheMostVerticalViewComesFirst) {
  const LocatedMap map = Read(ground::GroundSurface::Plane(0.0));
  const geo::Wgs84 below = map.frame.Wgs84FromEnu({31.0, 10.0, 0.0});
  const std::vector<Sighting> sightings = PhotosAtPoint(map, {below.lat_deg, below.lon_deg});
  ASSERT_GE(sightings.size(), 2u);
  EXPECT_EQ(sightings.front().photo, "p1");
  for (std::size_t i = 1; i < sightings.size(); ++i) {
    EXPECT_LE(sightings[i - 1].off_nadir_rad, sightings[i].off_nadir_rad);
  }
  EXPECT_TRUE(PhotosAtPoint(map, {48.0, 9.0}).empty());
}

TEST(Locate, SaysNoErrorOfAlignedPhotosWhereNothingSupportsThePlace) {
  alignment::AlignedFlight flight = Flight();
  flight.photos[1].placement = alignment::Placement::kPoseOnly;
  const Result<LocatedMap> map =
      ParseLocateJson(LocateJson(flight, Hills(), 0.0, alignment::ErrorsKnown::kOfPoseOnly));
  ASSERT_TRUE(map);
  const Result<GroundPoint> aligned = GroundAtPixel(*map, "p0", {2000, 1500});
  const Result<GroundPoint> by_pose = GroundAtPixel(*map, "p1", {2000, 1500});
  ASSERT_TRUE(aligned);
  ASSERT_TRUE(by_pose);
  EXPECT_FALSE(aligned->sigma_m);
  EXPECT_TRUE(by_pose->sigma_m);
  for (const Sighting& sighting : PhotosAtPoint(*map, aligned->position))
    EXPECT_EQ(sighting.sigma_m.has_value(), sighting.photo == "p1") << sighting.photo;
}

TEST(Locate, HeightsAreToldFromTheSurveysZeroAndPhotosSeeTheSamePlace) {
  const LocatedMap plain = Read(Hills());
  const auto raised = test::ValueOf(ParseLocateJson(LocateJson(Flight(), Hills(), -47.25)));
  const geo::LatLon place{plain.frame.origin().lat_deg + 1e-4, plain.frame.origin().lon_deg};
  EXPECT_NEAR(GroundAt(raised, place).height_ellipsoid_m, GroundAt(plain, place).height_ellipsoid_m - 47.25,
              1e-9);
  const std::vector<Sighting> before = PhotosAtPoint(plain, place), after = PhotosAtPoint(raised, place);
  ASSERT_FALSE(before.empty());
  ASSERT_EQ(after.size(), before.size());
  EXPECT_EQ(after.front().pixel_in_image, before.front().pixel_in_image);
}

TEST(Locate, WhatShowsNoGroundIsRefused) {
  alignment::AlignedFlight flight = Flight();
  flight.photos.push_back(PhotoAt("horizon", 0.0, 0.0, 1.5));
  const auto map = test::ValueOf(ParseLocateJson(LocateJson(flight, Hills())));
  EXPECT_EQ(GroundAtPixel(map, "horizon", {2000, 1500}).error().code, ErrorCode::kUnprocessable);
  EXPECT_EQ(GroundAtPixel(map, "p0", {4000, 10}).error().code, ErrorCode::kUnprocessable);
  EXPECT_EQ(GroundAtPixel(map, "unknown", {1, 1}).error().code, ErrorCode::kNotFound);
}

TEST(Locate, DamagedFilesAreRefused) {
  const std::string good = LocateJson(Flight(), Hills());
  for (std::size_t size = 0; size < good.size(); size += good.size() / 50) {
    EXPECT_FALSE(ParseLocateJson(good.substr(0, size)));
  }
  EXPECT_FALSE(ParseLocateJson(R"({"version":2})"));
  EXPECT_FALSE(ParseLocateJson(R"({"version":1,"origin":[1,2],"ground":{"z_m":0},"cameras":[]})"));
  EXPECT_FALSE(ParseLocateJson(
      R"({"version":1,"origin":[1,2,3],"ground":{"z_m":0,"heights_m":[1],"columns":2,"rows":2,"cell_m":1},"cameras":[]})"));
}

TEST(Locate, ASharpViewComesBeforeABlurredOneThatIsMoreVertical) {
  alignment::AlignedFlight flight = Flight();
  flight.photos[0].sharpness = 0.95;
  flight.photos[1].sharpness = 0.4;  // straight above the place
  flight.photos[2].sharpness = 1.3;
  const auto map = test::ValueOf(ParseLocateJson(LocateJson(flight, ground::GroundSurface::Plane(0.0))));
  const geo::Wgs84 below = map.frame.Wgs84FromEnu({31.0, 10.0, 0.0});
  const std::vector<Sighting> sightings = PhotosAtPoint(map, {below.lat_deg, below.lon_deg});
  ASSERT_GE(sightings.size(), 3u);
  EXPECT_NE(sightings.front().photo, "p1");
  for (std::size_t i = 0; i < sightings.size(); ++i) {
    const Sighting& one = sightings[i];
    if (i > 0) {
      EXPECT_LE(one.quality, sightings[i - 1].quality);
    }
    const double vertical = std::cos(one.off_nadir_rad);
    EXPECT_DOUBLE_EQ(one.quality, std::min(1.0, one.sharpness.value_or(1.0) / 0.8) * vertical * vertical);
    const auto& photo = flight.photos[static_cast<std::size_t>(one.photo[1] - '0')];
    EXPECT_EQ(one.sharpness, photo.sharpness) << "kept, and unknown where it is not known";
  }
}

}  // namespace
}  // namespace skyquilt::pipeline
