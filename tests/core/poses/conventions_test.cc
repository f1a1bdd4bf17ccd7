#include <gmock/gmock.h>

#include <cmath>
#include <cstddef>
#include <optional>
#include <random>
#include <string_view>
#include <vector>

#include "core/geo/lat_lon.h"
#include "core/poses/conventions/attitude_convention.h"
#include "core/poses/conventions/choose_convention.h"

namespace skyquilt::poses {
namespace {

using flight::AttitudeKind;
using flight::Photo;
using geo::DegToRad;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

flight::RecordedAttitude Angles(AttitudeKind kind, double yaw_deg, double pitch_deg, double roll_deg) {
  flight::RecordedAttitude attitude;
  attitude.kind = kind;
  attitude.yaw_rad = DegToRad(yaw_deg);
  attitude.pitch_rad = DegToRad(pitch_deg);
  attitude.roll_rad = DegToRad(roll_deg);
  return attitude;
}

Eigen::Vector3d AxisInEnu(const Eigen::Quaterniond& cam_from_enu) {
  return cam_from_enu.conjugate() * Eigen::Vector3d::UnitZ();
}
Eigen::Vector3d ImageTopInEnu(const Eigen::Quaterniond& cam_from_enu) {
  return cam_from_enu.conjugate() * -Eigen::Vector3d::UnitY();
}

TEST(CamFromEnu, LooksDownWithTheImageTopTowardsTheYaw) {
  const Eigen::Quaterniond east = CamFromEnu(Angles(AttitudeKind::kGimbal, 90, -90, 0));
  EXPECT_LT((AxisInEnu(east) - Eigen::Vector3d(0, 0, -1)).norm(), 1e-12);
  EXPECT_LT((ImageTopInEnu(east) - Eigen::Vector3d(1, 0, 0)).norm(), 1e-12);
}

TEST(CamFromEnu, LooksAtTheHorizonInTheDirectionOfTheYaw) {
  const Eigen::Quaterniond west = CamFromEnu(Angles(AttitudeKind::kGimbal, -90, 0, 0));
  EXPECT_LT((AxisInEnu(west) - Eigen::Vector3d(-1, 0, 0)).norm(), 1e-12);
  EXPECT_LT((ImageTopInEnu(west) - Eigen::Vector3d(0, 0, 1)).norm(), 1e-12);
}

TEST(CamFromEnu, OfALevelAirframeIsTheNadirGimbal) {
  for (const double yaw_deg : {-170.0, -20.0, 0.0, 133.0}) {
    const Eigen::Quaterniond body = CamFromEnu(Angles(AttitudeKind::kAirframe, yaw_deg, 0, 0));
    EXPECT_LT(body.angularDistance(CamFromEnu(Angles(AttitudeKind::kGimbal, yaw_deg, -90, 0))), 1e-9);
    EXPECT_LT(body.angularDistance(NadirCamFromEnu(DegToRad(yaw_deg))), 1e-9);
  }
}

TEST(CamFromEnu, LeansTheWayTheAirframeLeans) {
  // Nose up swings the camera's view forward; right wing down swings it to the left.
  EXPECT_GT(AxisInEnu(CamFromEnu(Angles(AttitudeKind::kAirframe, 0, 10, 0))).y(), 0.1);
  EXPECT_LT(AxisInEnu(CamFromEnu(Angles(AttitudeKind::kAirframe, 0, 0, 10))).x(), -0.1);
}

TEST(AnglesOf, GivesBackWhatWentInAwayFromTheSingularity) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (int i = 0; i < 200; ++i) {
    const double yaw = 179.0 * unit(random);
    const CameraAngles oblique =
        AnglesOf(CamFromEnu(Angles(AttitudeKind::kGimbal, yaw, -20 + 15 * unit(random), 8 * unit(random))));
    EXPECT_NEAR(geo::WrapRad(oblique.yaw_rad - DegToRad(yaw)), 0.0, 1e-9);
    const double pitch = -90 + 30 * unit(random);
    const CameraAngles nadir = AnglesOf(CamFromEnu(Angles(AttitudeKind::kGimbal, yaw, pitch, 0)));
    EXPECT_NEAR(geo::WrapRad(nadir.yaw_rad - DegToRad(yaw)), 0.0, 1e-9);
    EXPECT_NEAR(nadir.pitch_rad, DegToRad(pitch), 1e-9);
    EXPECT_NEAR(nadir.roll_rad, 0.0, 1e-9);
  }
}

TEST(CoursesFromPositions, TakesTheStraightRunAtALinesEnd) {
  std::vector<Eigen::Vector2d> lawnmower;
  for (int i = 0; i < 5; ++i) lawnmower.emplace_back(0.0, 10.0 * i);
  for (int i = 4; i >= 0; --i) lawnmower.emplace_back(15.0, 10.0 * i);
  const auto courses = CoursesFromPositions(lawnmower);
  for (int i = 0; i < 5; ++i) EXPECT_NEAR(*courses[static_cast<std::size_t>(i)], 0.0, 1e-9) << i;
  for (int i = 5; i < 10; ++i)
    EXPECT_NEAR(std::abs(*courses[static_cast<std::size_t>(i)]), geo::kPi, 1e-9) << i;
}

// A film flown north and photos flown east half a kilometre off, whose clocks make them one row.
TEST(CoursesOfCameras, GoByTheirOwnWaysWhereClocksMixThem) {
  std::vector<Eigen::Vector2d> positions;
  std::vector<std::string_view> cameras;
  for (int i = 0; i < 6; ++i) {
    positions.emplace_back(0.0, 5.0 * i);
    cameras.emplace_back("film");
    positions.emplace_back(200.0 + 30.0 * i, 500.0);
    cameras.emplace_back("photos");
  }
  positions.emplace_back(10.0, 40.0);
  cameras.emplace_back("lone");  // goes by all
  const auto courses = CoursesOfCameras(cameras, positions);
  for (std::size_t i = 0; i < 12; ++i)
    EXPECT_NEAR(courses[i].value_or(9.0), i % 2 == 0 ? 0.0 : 0.5 * geo::kPi, 1e-9) << i;
  EXPECT_TRUE(courses[12].has_value());
}

TEST(CoursesOfCameras, OfOneAircraftAreThatOfAll) {
  std::vector<Eigen::Vector2d> lawnmower, twice;
  std::vector<std::string_view> in_turn, at_once;
  for (int i = 0; i < 16; ++i) {
    lawnmower.emplace_back(i < 8 ? 0.0 : 15.0, 10.0 * (i < 8 ? i : 15 - i));
    in_turn.emplace_back(i % 2 == 0 ? "a" : "b");
    for (const char* camera : {"a", "b"}) {
      twice.push_back(lawnmower.back());
      at_once.emplace_back(camera);
    }
  }
  EXPECT_EQ(CoursesOfCameras(in_turn, lawnmower), CoursesFromPositions(lawnmower));
  EXPECT_EQ(CoursesOfCameras(at_once, twice), CoursesFromPositions(twice));
}

// The camera's steps are 10 m, those to its photos from the one before half a metre more at one of them.
TEST(CoursesOfCameras, OfAZoomThatChangesAmidALineAreThatOfAll) {
  std::vector<Eigen::Vector2d> positions;
  std::vector<std::string_view> cameras;
  for (int i = 0; i < 12; ++i) {
    const double north_m = 10.0 * (i < 8 ? i : 15 - i) - (i < 5 ? 0.5 : 0.0);
    positions.emplace_back(i < 8 ? 0.0 : 15.0, north_m);
    cameras.emplace_back(i >= 5 && i < 9 ? "zoomed in" : "zoomed out");
  }
  const auto courses = CoursesOfCameras(cameras, positions);
  EXPECT_EQ(courses, CoursesFromPositions(positions));
  EXPECT_NEAR(std::abs(courses[8].value_or(0.0)), geo::kPi, 1e-9) << "the first of the next line";
}

TEST(CoursesFromPositions, SaysNothingWhereNothingMoved) {
  const auto courses = CoursesFromPositions({{0, 0}, {0.2, 0}, {0.1, 0.1}});
  for (const auto& course : courses) EXPECT_FALSE(course.has_value());
  EXPECT_TRUE(CoursesFromPositions({{0, 0}}).size() == 1);
}

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

TEST(ChooseConvention, FindsAnotherReadingUnderWhichThePhotosLookDown) {
  const struct {
    AttitudeKind kind;
    double pitch_deg;
    double down;  // at least
  } cases[] = {
      {AttitudeKind::kGimbal, 0.0, 0.99},      // counts from nadir
      {AttitudeKind::kGimbal, 70.0, 0.9},      // counts downwards
      {AttitudeKind::kAirframe, -88.0, 0.99},  // the camera's, named the airframe's
  };
  for (const auto& [kind, pitch_deg, down] : cases) {
    std::vector<Photo> photos = Flown(kind, 0.0, pitch_deg);
    EXPECT_TRUE(ChooseConvention(photos, {}).is_changed) << pitch_deg;
    for (const Photo& photo : photos) EXPECT_GT(DownOf(photo), down) << pitch_deg;
  }
}

TEST(ChooseConvention, ReadsEachMakerOfAFleetByItsOwnConvention) {
  // So many count from the horizon and so many from nadir, one behind the other or in turn.
  const struct {
    int horizon, nadir;
    bool in_turn;
  } fleets[] = {{6, 6, false}, {6, 6, true}, {2, 10, false}};
  for (const auto& [horizon, nadir, in_turn] : fleets) {
    SCOPED_TRACE(testing::Message() << horizon << " and " << nadir << (in_turn ? " in turn" : ""));
    std::vector<Photo> from_horizon = Flown(AttitudeKind::kGimbal, 0.0, -90.0, horizon);
    for (Photo& photo : from_horizon) photo.make = "One";
    std::vector<Photo> from_nadir = Flown(AttitudeKind::kGimbal, 0.0, 0.0, nadir);
    for (Photo& photo : from_nadir) photo.make = "Other";
    std::vector<Photo> photos = from_horizon;
    for (std::size_t i = 0; i < from_nadir.size(); ++i) {
      const std::size_t at = in_turn ? 2 * i + 1 : photos.size();
      photos.insert(photos.begin() + static_cast<std::ptrdiff_t>(at), from_nadir[i]);
    }
    EXPECT_TRUE(ChooseConvention(photos, {}).is_changed);
    for (const Photo& photo : photos) EXPECT_GT(DownOf(photo), 0.99) << photo.make;
  }
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
