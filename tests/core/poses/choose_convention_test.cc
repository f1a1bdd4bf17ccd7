#include "core/poses/conventions/choose_convention.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/geo/lat_lon.h"
#include "core/poses/conventions/attitude_convention.h"

namespace skyquilt::poses {
namespace {

using flight::AttitudeKind;
using flight::Photo;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// Ten photos flown north at 60 m, one every 12 m.
std::vector<Photo> Flown(AttitudeKind kind, double yaw_deg, double pitch_deg, int count = 10) {
  std::vector<Photo> photos;
  for (int k = 0; k < count; ++k) {
    Photo photo;
    photo.intrinsics = camera::Intrinsics::Centered(4000, 3000, 3665.0);
    photo.position.emplace();
    photo.position->position = {47.4 + 12.0 * k / 111200.0, 8.5};
    photo.position->height_above_takeoff_m = 60.0;
    photo.attitude = flight::RecordedAttitude{kind, geo::DegToRad(yaw_deg + 2.0 * std::sin(1.7 * k)),
                                              geo::DegToRad(pitch_deg + std::sin(2.3 * k)), 0.0, "test"};
    photos.push_back(photo);
  }
  return photos;
}

double DownOf(const Photo& photo) {
  return -(CamFromEnu(*photo.attitude).conjugate() * Eigen::Vector3d::UnitZ()).z();
}

TEST(ChooseConvention, LeavesAnglesThatFit) {
  std::vector<Photo> photos = Flown(AttitudeKind::kGimbal, 0.0, -90.0);
  const ConventionChoice choice = ChooseConvention(photos, {});
  EXPECT_FALSE(choice.is_changed);
  EXPECT_THAT(choice.words, HasSubstr("read as recorded"));
  EXPECT_NEAR(photos[3].attitude->pitch_rad, geo::DegToRad(-90.0), 0.02);
}

TEST(ChooseConvention, FindsAPitchThatCountsFromNadir) {
  std::vector<Photo> photos = Flown(AttitudeKind::kGimbal, 0.0, 0.0);
  const ConventionChoice choice = ChooseConvention(photos, {});
  EXPECT_TRUE(choice.is_changed);
  for (const Photo& photo : photos) EXPECT_GT(DownOf(photo), 0.99);
}

TEST(ChooseConvention, FindsAPitchThatCountsDownwards) {
  std::vector<Photo> photos = Flown(AttitudeKind::kGimbal, 0.0, 70.0);
  const ConventionChoice choice = ChooseConvention(photos, {});
  EXPECT_TRUE(choice.is_changed);
  for (const Photo& photo : photos) EXPECT_GT(DownOf(photo), 0.9);
}

TEST(ChooseConvention, FindsAnglesOfTheCameraNamedThoseOfTheAirframe) {
  std::vector<Photo> photos = Flown(AttitudeKind::kAirframe, 0.0, -88.0);
  const ConventionChoice choice = ChooseConvention(photos, {});
  EXPECT_TRUE(choice.is_changed);
  EXPECT_GT(DownOf(photos[0]), 0.99);
}

TEST(ChooseConvention, BelievesAFewPhotosThatLookAtTheHorizon) {
  std::vector<Photo> photos = Flown(AttitudeKind::kGimbal, 0.0, -3.0, 3);
  EXPECT_FALSE(ChooseConvention(photos, {}).is_changed);
}

TEST(ChooseConvention, ReportsASidewaysFlightAndLeavesIt) {
  std::vector<Photo> photos = Flown(AttitudeKind::kGimbal, -89.0, -90.0);
  const std::vector<std::optional<double>> airframe(photos.size(), geo::DegToRad(-89.0));
  const ConventionChoice choice = ChooseConvention(photos, airframe);
  EXPECT_FALSE(choice.is_changed);
  EXPECT_THAT(choice.words, HasSubstr("heading minus course -8"));
  EXPECT_THAT(choice.words, HasSubstr("the log's airframe"));
}

TEST(ChooseConvention, HasNothingToSayWithoutAngles) {
  std::vector<Photo> photos(3);
  EXPECT_THAT(ChooseConvention(photos, {}).words, IsEmpty());
}

}  // namespace
}  // namespace skyquilt::poses
