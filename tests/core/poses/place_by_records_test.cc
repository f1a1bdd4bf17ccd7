// How photos that record no angles are turned where no picture tells.
#include "core/poses/place_by_records.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "core/geo/lat_lon.h"
#include "core/poses/conventions/attitude_convention.h"
#include "core/poses/estimate_poses.h"
#include "tests/support/value_of.h"

namespace skyquilt::poses {
namespace {

using flight::Photo;
using flight::RecordedDirection;
using flight::RemarkCode;

constexpr geo::LatLon kPasture{47.4, 8.5};

// 60 m above the ground, of which it shows 82 m from corner to corner.
Photo WithCompass(double north_m, std::optional<double> direction_deg, bool is_from_true_north = true) {
  Photo photo;
  photo.name = "at " + std::to_string(north_m);
  photo.intrinsics = camera::Intrinsics::Centered(4000, 3000, 3665.0);
  photo.position.emplace();
  photo.position->position = {kPasture.lat_deg + north_m / 111200.0, kPasture.lon_deg};
  photo.position->height_above_takeoff_m = 60.0;
  if (direction_deg) photo.direction = RecordedDirection{geo::DegToRad(*direction_deg), is_from_true_north};
  return photo;
}

PlacedByRecords PlaceThem(const std::vector<Photo>& photos) {
  const geo::LocalFrame frame({kPasture.lat_deg, kPasture.lon_deg, 450.0});
  return PlaceByRecords(photos, ChooseHeights(photos, nullptr), frame);
}

double TurnedDeg(const PosedPhoto& photo) {
  return geo::RadToDeg(AnglesOf(photo.cam_from_enu.rotation).yaw_rad);
}

double SigmaTurnedDeg(const PosedPhoto& photo) { return geo::RadToDeg(std::sqrt(photo.covariance(2, 2))); }

TEST(PlaceByRecords, TurnsALonePhotoAsItsCompassSays) {
  for (const bool is_from_true_north : {true, false}) {
    const PlacedByRecords placed = PlaceThem({WithCompass(0.0, 70.0, is_from_true_north)});
    ASSERT_EQ(placed.photos.size(), 1u);
    EXPECT_EQ(placed.photos[0].attitude_origin, AttitudeOrigin::kDirection);
    EXPECT_NEAR(TurnedDeg(placed.photos[0]), 70.0, 1e-6);
    EXPECT_NEAR(SigmaTurnedDeg(placed.photos[0]), is_from_true_north ? 15.0 : 25.0, 1e-6);
    EXPECT_EQ(placed.without_angles, 1u);
    EXPECT_EQ(placed.by_direction, 1u);
  }
  const PlacedByRecords unsaid = PlaceThem({WithCompass(0.0, std::nullopt)});
  ASSERT_EQ(unsaid.photos.size(), 1u);
  EXPECT_EQ(unsaid.photos[0].attitude_origin, AttitudeOrigin::kCourse);
  EXPECT_NEAR(SigmaTurnedDeg(unsaid.photos[0]), 180.0, 1e-6);
}

TEST(PlaceByRecords, TurnsPhotosThatShareNoGroundAsTheirCompassSays) {
  const PlacedByRecords apart =
      PlaceThem({WithCompass(0.0, 80.0), WithCompass(100.0, -85.0), WithCompass(200.0, std::nullopt)});
  ASSERT_EQ(apart.photos.size(), 3u);
  EXPECT_NEAR(TurnedDeg(apart.photos[0]), 80.0, 1e-6);
  EXPECT_NEAR(TurnedDeg(apart.photos[1]), -85.0, 1e-6);
  EXPECT_NEAR(TurnedDeg(apart.photos[2]), 0.0, 0.1) << "along the course";
  EXPECT_EQ(apart.by_direction, 2u);
  const PlacedByRecords together =
      PlaceThem({WithCompass(0.0, 80.0), WithCompass(12.0, -85.0), WithCompass(24.0, 90.0)});
  for (const PosedPhoto& photo : together.photos) {
    EXPECT_EQ(photo.attitude_origin, AttitudeOrigin::kCourse) << "what they show turns them";
    EXPECT_NEAR(TurnedDeg(photo), 0.0, 0.1);
  }
}

TEST(PlaceByRecords, BelievesNoCompassThatSaysOneDirectionOfAllPhotos) {
  const PlacedByRecords placed = PlaceThem({WithCompass(0.0, 89.0), WithCompass(100.0, 89.0)});
  EXPECT_EQ(placed.photos.size(), 2u);
  for (const PosedPhoto& photo : placed.photos) EXPECT_EQ(photo.attitude_origin, AttitudeOrigin::kCourse);
}

TEST(PlaceByRecords, BelievesRecordedAnglesBeforeACompass) {
  Photo photo = WithCompass(0.0, 70.0);
  photo.attitude = flight::RecordedAttitude{flight::AttitudeKind::kGimbal, geo::DegToRad(20.0),
                                            geo::DegToRad(-90.0), 0.0, ""};
  const PlacedByRecords placed = PlaceThem({photo});
  ASSERT_EQ(placed.photos.size(), 1u);
  EXPECT_EQ(placed.photos[0].attitude_origin, AttitudeOrigin::kRecorded);
  EXPECT_NEAR(TurnedDeg(placed.photos[0]), 20.0, 1e-6);
  EXPECT_EQ(placed.by_direction, 0u);
}

TEST(PlaceByRecords, HoldsNoPositionToAnAccuracyThatNobodyMeasured) {
  for (const double sigma_m : {1e-4, 0.001}) {
    Photo photo = WithCompass(0.0, std::nullopt);
    photo.position->sigma_horizontal_m = sigma_m;
    const PlacedByRecords placed = PlaceThem({photo});
    ASSERT_EQ(placed.photos.size(), 1u);
    EXPECT_DOUBLE_EQ(std::sqrt(placed.photos[0].covariance(3, 3)), flight::kPlainSigmaM) << sigma_m;
  }
}

TEST(EstimatePoses, SaysThatACompassTurnsPhotos) {
  flight::Flight flight;
  flight.photos = {WithCompass(0.0, 70.0)};
  const PosedFlight posed = test::ValueOf(EstimatePoses(flight, {}));
  ASSERT_EQ(posed.assumptions.size(), 1u);
  EXPECT_EQ(posed.assumptions[0].missing.code, RemarkCode::kNoAngles);
  EXPECT_EQ(posed.assumptions[0].assumed,
            (flight::Remark{RemarkCode::kAnglesAssumedByDirection, {{"photos", 1}}}));
}

TEST(PlaceByRecords, TellsThatAnOriginIsNotUsedWherePhotosSayWhereTheyWere) {
  flight::Flight flight;
  flight.photos = {WithCompass(0.0, 0.0), WithCompass(30.0, 0.0), WithCompass(60.0, 0.0)};
  EstimatePosesOptions options;
  const auto is_told = [&] {
    const PosedFlight posed = test::ValueOf(EstimatePoses(flight, options));
    return std::any_of(posed.warnings.begin(), posed.warnings.end(), [](const flight::Remark& remark) {
      return remark.code == RemarkCode::kOriginNotUsed;
    });
  };
  EXPECT_FALSE(is_told());
  options.origin = geo::LatLon{46.8, 7.1};
  EXPECT_TRUE(is_told());
}

}  // namespace
}  // namespace skyquilt::poses
