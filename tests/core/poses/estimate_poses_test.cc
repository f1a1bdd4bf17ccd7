#include "core/poses/estimate_poses.h"

#include <gmock/gmock.h>

#include <cmath>
#include <utility>
#include <vector>

#include "core/flight/logs/log_builder.h"
#include "core/flight/remarks/remark_words.h"
#include "core/geo/geoid.h"
#include "core/poses/photo_rows.h"
#include "core/poses/time/join_logs.h"
#include "tests/support/value_of.h"

namespace skyquilt::poses {
namespace {

using flight::CameraEvent;
using flight::Flight;
using flight::FlightLog;
using flight::Photo;
using test::ErrorOf;
using test::ValueOf;
using ::testing::Contains;
using ::testing::HasSubstr;

constexpr flight::UtcTime kNoon{std::chrono::seconds(1717243200)};
constexpr geo::LatLon kField{47.4, 8.5};
constexpr double kGroundM = 450.0;

flight::UtcTime After(double seconds) {
  return kNoon + std::chrono::microseconds(std::llround(1e6 * seconds));
}

// North at 8 m/s, 60 m above the ground.
geo::Wgs84 TrueAt(double t_s) {
  const geo::LocalFrame frame({kField.lat_deg, kField.lon_deg, kGroundM});
  return frame.Wgs84FromEnu({0.0, 8.0 * t_s, 60.0});
}

// A pause after the fifth: only so is a shift by one photo seen. Stamps in full milliseconds, as exact ones
// are.
double TimeOf(int k) { return 20.137 + 2.0 * k + (k > 4 ? 3.0 : 0.0); }

std::vector<Photo> PhotosEvery2s(int count, double clock_ahead_s = 0.0) {
  std::vector<Photo> photos;
  for (int k = 0; k < count; ++k) {
    Photo photo;
    photo.name = "IMG_" + std::to_string(k) + ".JPG";
    photo.intrinsics = camera::Intrinsics::Centered(4000, 3000, 3665.0);
    photo.captured_at = After(TimeOf(k) + clock_ahead_s);
    photos.push_back(photo);
  }
  return photos;
}

FlightLog Track(double begin_s, double end_s, double zero_s = 0.0) {
  FlightLog log;
  log.format = "test";
  log.file_name = "track.log";
  log.utc_at_zero = After(zero_s);
  for (double t = begin_s; t <= end_s; t += 0.2) {
    const geo::Wgs84 at = TrueAt(t);
    flight::GnssSample fix;
    fix.t_s = t - zero_s;
    fix.position = {at.lat_deg, at.lon_deg};
    fix.height_ellipsoid_m = at.height_ellipsoid_m;
    fix.velocity_in_ned_mps = Eigen::Vector3d(8.0, 0.0, 0.0);
    log.gnss.push_back(fix);
    log.baro.push_back({t - zero_s, at.height_ellipsoid_m - kGroundM});
    log.attitude.push_back({t - zero_s, flight::NedFromYawPitchRoll(0.0, -0.1, 0.0), true});
  }
  return log;
}

// 60 m above the take-off, as it says.
flight::RecordedPosition& StandAt(const geo::LatLon& place, Photo& photo) {
  flight::RecordedPosition& position = photo.position.emplace();
  position.position = place;
  position.height_above_takeoff_m = 60.0;
  return position;
}

geo::LatLon TruePlaceAt(double t_s) { return {TrueAt(t_s).lat_deg, TrueAt(t_s).lon_deg}; }

Flight FlightOf(std::vector<Photo> photos, std::vector<FlightLog> logs = {}) {
  Flight flight;
  flight.photos = std::move(photos);
  flight.logs = std::move(logs);
  return flight;
}

Result<PosedFlight> Estimate(const Flight& flight, const EstimatePosesOptions& options = {}) {
  return EstimatePoses(flight, options);
}

double OffM(const PosedFlight& posed, const PosedPhoto& photo, double t_s) {
  return (photo.cam_from_enu.TargetOriginInSource() - posed.frame.EnuFromWgs84(TrueAt(t_s))).head<2>().norm();
}

TEST(EstimatePoses, PlacesPhotosWithoutGpsByALogsTrack) {
  Flight flight = FlightOf(PhotosEvery2s(10), {Track(0.0, 60.0)});
  const auto posed = ValueOf(Estimate(flight));
  ASSERT_EQ(posed.photos.size(), 10u);
  EXPECT_EQ(posed.report.photos_by_log, 10);
  for (int k = 0; k < 10; ++k) {
    const PosedPhoto& photo = posed.photos[static_cast<std::size_t>(k)];
    // Clocks as they stand: the camera's is held for good to two seconds, and the radius says so.
    EXPECT_LT(OffM(posed, photo, TimeOf(k)), 1.0);
    EXPECT_GT(photo.error_radius_m, 8.0);
    EXPECT_NEAR(photo.clock_sigma_s, 2.0, 0.1);
    EXPECT_EQ(photo.position_source, "track.log");
    EXPECT_NEAR(photo.height_above_ground_m, 60.0, 0.5);
  }
}

TEST(EstimatePoses, TakesASparseTrackToHoldForHalfOfItsInterval) {
  Flight flight = FlightOf(PhotosEvery2s(10));
  FlightLog log = Track(0.0, 60.0);
  log.baro.clear();
  log.attitude.clear();
  const std::vector<flight::GnssSample> all = std::exchange(log.gnss, {});
  for (const flight::GnssSample& fix : all) {
    if (log.gnss.empty() || fix.t_s - log.gnss.back().t_s > 5.9) log.gnss.push_back(fix);
  }
  std::erase_if(log.gnss, [](const flight::GnssSample& fix) { return fix.t_s > 37.0; });  // to 36 s
  flight.logs = {log};
  EXPECT_EQ(Estimate(flight)->report.photos_by_log, 8) << "the photo of 37.1 s, not that of 39.1 s";
}

TEST(EstimatePoses, TellsWhatCameOfALogAndHowItAgreesWithThePhotos) {
  Flight flight = FlightOf(PhotosEvery2s(10), {Track(0.0, 60.0)});
  EXPECT_THAT(Estimate(flight)->report.logs,
              Contains("track.log (test): 10 of 10 photos placed by its series"));
  for (int k = 0; k < 10; ++k) {
    const geo::Wgs84 at = TrueAt(TimeOf(k));
    flight::RecordedPosition& own = flight.photos[static_cast<std::size_t>(k)].position.emplace();
    own.position = {at.lat_deg, at.lon_deg + 4.0 / 75'400.0};  // beside the track, so that no other time fits
    own.source = "exif";
  }
  EXPECT_THAT(
      Estimate(flight)->report.logs,
      Contains(
          "track.log (test): 10 of 10 photos placed by its series, 4.0 m from the photos' own positions"));
}

TEST(EstimatePoses, TiesPhotosToCameraEventsHoweverWrongTheClock) {
  Flight flight = FlightOf(PhotosEvery2s(10, 3607.3));
  FlightLog log = Track(0.0, 60.0);
  for (const Photo& photo : PhotosEvery2s(10)) {
    CameraEvent event;
    event.t_s = std::chrono::duration<double>(*photo.captured_at - kNoon).count();
    log.events.push_back(event);
  }
  flight.logs = {log};
  const auto posed = ValueOf(Estimate(flight));
  ASSERT_EQ(posed.photos.size(), 10u);
  EXPECT_NEAR(*posed.report.camera_ahead_of_utc_s, 3607.3, 0.02);
  EXPECT_LT(OffM(posed, posed.photos[9], TimeOf(9)), 0.5);
  EXPECT_LT(posed.photos[9].error_radius_m, 6.0);
}

TEST(EstimatePoses, LeavesALogOfAnotherFlightAlone) {
  Flight flight = FlightOf(PhotosEvery2s(10));
  for (int k = 0; k < 10; ++k) {
    Photo& photo = flight.photos[static_cast<std::size_t>(k)];
    photo.captured_at_is_local = true;
    StandAt({kField.lat_deg + 0.1 + 1e-4 * k, kField.lon_deg}, photo);  // 11 km from the log
  }
  flight.logs = {Track(0.0, 60.0)};
  const auto posed = ValueOf(Estimate(flight));
  EXPECT_EQ(posed.report.photos_by_log, 0);
  EXPECT_EQ(posed.report.photos_by_records, 10);
  EXPECT_THAT(InWords(posed.warnings), Contains(HasSubstr("track.log")));
  EXPECT_THAT(posed.report.logs, Contains("track.log (test): no photo is placed by it"));
}

TEST(EstimatePoses, LeavesOutPhotosOutsideTheLogThatHaveNoPositionOfTheirOwn) {
  Flight flight = FlightOf(PhotosEvery2s(10));
  StandAt(TruePlaceAt(TimeOf(9)), flight.photos[9]);
  flight.logs = {Track(0.0, 30.0)};
  const auto posed = ValueOf(Estimate(flight));
  EXPECT_EQ(posed.report.photos_by_log, 5);
  EXPECT_EQ(posed.report.photos_by_records, 1);
  ASSERT_EQ(posed.left_out.size(), 4u);
  EXPECT_THAT(InWords(posed.left_out[0].reason), HasSubstr("does not cover"));
}

TEST(EstimatePoses, TakesPositionsFromAListThatNamesThePhotos) {
  Flight flight = FlightOf(PhotosEvery2s(3));
  FlightLog list;
  list.format = "geo_txt";
  list.file_name = "geo.txt";
  for (int k = 0; k < 3; ++k) {
    CameraEvent row;
    row.has_time = false;
    row.t_s = k;
    row.image_name = "img_" + std::to_string(k) + ".jpg";
    row.position = geo::LatLon{kField.lat_deg + 1e-4 * k, kField.lon_deg};
    row.height_ellipsoid_m = kGroundM + 60.0;
    row.height_above_takeoff_m = 60.0;
    list.events.push_back(row);
  }
  flight.logs = {list};
  const auto posed = ValueOf(Estimate(flight));
  ASSERT_EQ(posed.photos.size(), 3u);
  EXPECT_EQ(posed.photos[0].position_source, "geo.txt");
  EXPECT_THAT(posed.report.logs, Contains(HasSubstr("names 3 of 3 photos")));
}

// A row a photo, of angles alone.
FlightLog ListOfAngles(int count, const Eigen::Vector3d& yaw_pitch_roll_rad, flight::AttitudeKind kind) {
  FlightLog list;
  list.format = "pix4d_csv";
  list.file_name = "geolocation.csv";
  for (int k = 0; k < count; ++k) {
    CameraEvent& row = list.events.emplace_back();
    row.has_time = false;
    row.t_s = k;
    row.image_name = "IMG_" + std::to_string(k) + ".JPG";
    row.yaw_pitch_roll_rad = yaw_pitch_roll_rad;
    row.attitude_kind = kind;
  }
  return list;
}

TEST(ApplyPhotoRows, LeavesCamerasTheAnglesOfTheirOwnGimbal) {
  const flight::RecordedAttitude own{flight::AttitudeKind::kGimbal, 0.8, -0.5 * geo::kPi, 0.0, "drone-dji"};
  std::vector<Photo> photos = PhotosEvery2s(3);
  for (Photo& photo : photos) photo.attitude = own;

  // The same from nadir, as lists write it: nothing to say but whose hold.
  const auto same =
      ApplyPhotoRows({ListOfAngles(3, {0.8, 0.0, 0.0}, flight::AttitudeKind::kAirframe)}, photos);
  EXPECT_EQ(photos[2].attitude->source, "drone-dji");
  EXPECT_THAT(same.lines, Contains(HasSubstr("3 photos keep the angles of their own gimbal, 0.0 degrees")));
  EXPECT_TRUE(same.warnings.empty());

  // An aircraft that leans.
  const auto other =
      ApplyPhotoRows({ListOfAngles(3, {0.8, -0.3, 0.1}, flight::AttitudeKind::kAirframe)}, photos);
  EXPECT_EQ(photos[2].attitude->source, "drone-dji");
  EXPECT_THAT(InWords(other.warnings), Contains(HasSubstr("geolocation.csv: its angles lie 18 degrees")));
}

TEST(ApplyPhotoRows, TakesAnglesThatAreBetterOrTheOnlyOnes) {
  std::vector<Photo> photos = PhotosEvery2s(3);
  photos[0].attitude = flight::RecordedAttitude{flight::AttitudeKind::kGimbal, 0.8, -1.5, 0.0, "drone-dji"};
  photos[1].attitude = flight::RecordedAttitude{flight::AttitudeKind::kAirframe, 0.8, 0.0, 0.0, "Camera"};
  std::vector<Photo> others = photos;
  ApplyPhotoRows({ListOfAngles(3, {0.7, 0.0, 0.0}, flight::AttitudeKind::kAirframe)}, photos);
  EXPECT_EQ(photos[0].attitude->source, "drone-dji");
  EXPECT_EQ(photos[1].attitude->source, "geolocation.csv");
  EXPECT_EQ(photos[2].attitude->source, "geolocation.csv");
  ApplyPhotoRows({ListOfAngles(3, {0.7, -1.5, 0.0}, flight::AttitudeKind::kGimbal)}, others);
  EXPECT_EQ(others[0].attitude->source, "geolocation.csv") << "the camera's own, as a recorder wrote them";
}

TEST(EstimatePoses, HoldsForSurveyedTheHeightsThatACorrectedRowSays) {
  FlightLog list = ListOfAngles(3, {0.0, 0.0, 0.0}, flight::AttitudeKind::kAirframe);
  for (CameraEvent& row : list.events) {
    row.position = geo::LatLon{kField.lat_deg + 1e-4 * row.t_s, kField.lon_deg};
    row.is_rtk_fixed = true;
  }
  std::vector<Photo> photos = PhotosEvery2s(3);
  for (Photo& photo : photos) StandAt(kField, photo).height_amsl_m = 512.0;
  const auto sigma_up_m = [&](const FlightLog& rows) {
    const auto posed = ValueOf(Estimate(FlightOf(photos, {rows})));
    return std::sqrt(posed.photos.at(1).covariance(5, 5));
  };
  EXPECT_GT(sigma_up_m(list), 0.5) << "a barometer's";
  for (CameraEvent& row : list.events) row.height_amsl_m = 512.0 + row.t_s;
  EXPECT_LT(sigma_up_m(list), 0.1);
  const auto posed = ValueOf(Estimate(FlightOf(photos, {list})));
  EXPECT_NEAR(posed.photos.at(2).height_above_ground_m - posed.photos.at(0).height_above_ground_m, 2.0, 0.01);
}

TEST(ApplyPhotoRows, AsksForFoldersWhereTwoCardsShareTheirNames) {
  std::vector<Photo> photos = PhotosEvery2s(2);
  photos[0].name = "100MEDIA/IMG_0.JPG";
  photos[1].name = "101MEDIA/IMG_0.JPG";
  FlightLog list = ListOfAngles(1, {0.7, 0.0, 0.0}, flight::AttitudeKind::kAirframe);
  const auto open = ApplyPhotoRows({list}, photos);
  EXPECT_FALSE(photos[0].attitude || photos[1].attitude);
  EXPECT_THAT(InWords(open.warnings), Contains(HasSubstr("of 1 row (IMG_0.JPG)")));
  list.events[0].image_name = "DCIM/101MEDIA/IMG_0.JPG";
  EXPECT_TRUE(ApplyPhotoRows({list}, photos).warnings.empty());
  EXPECT_TRUE(!photos[0].attitude && photos[1].attitude);
}

TEST(EstimatePoses, KnowsNeighboursBetterAgainstEachOtherThanAgainstTheGround) {
  Flight flight = FlightOf(PhotosEvery2s(4));
  for (int k = 0; k < 4; ++k) StandAt(TruePlaceAt(TimeOf(k)), flight.photos[static_cast<std::size_t>(k)]);
  const auto posed = ValueOf(Estimate(flight));
  for (std::size_t k = 0; k + 1 < posed.photos.size(); ++k) {
    const Matrix6d& cross = posed.photos.at(k).covariance_with_next;
    const Matrix6d own = posed.photos.at(k).covariance;
    const Matrix6d difference = own + posed.photos.at(k + 1).covariance - cross - cross.transpose();
    for (int i = 0; i < 6; ++i) {
      EXPECT_GT(difference(i, i), 0.0);
      EXPECT_LT(difference(i, i), (i < 3 ? 0.3 : 0.15) * own(i, i)) << i;
    }
  }
  EXPECT_EQ(posed.photos.back().covariance_with_next, Matrix6d::Zero());
}

// 16 m apart with the usual three quarters of overlap: 78 m up.
TEST(EstimatePoses, GuessesTheHeightFromTheSpacingWhereNothingSaysIt) {
  Flight flight = FlightOf(PhotosEvery2s(6));
  for (std::size_t i = 0; i < flight.photos.size(); ++i) {
    const geo::Wgs84 at = TrueAt(2.0 * static_cast<double>(i));
    flight::RecordedPosition& position = flight.photos[i].position.emplace();
    position.position = {at.lat_deg, at.lon_deg};
  }
  for (const bool has_absolute_heights : {false, true}) {
    if (has_absolute_heights) {
      for (Photo& photo : flight.photos) photo.position->height_amsl_m = 512.0;
    }
    const auto posed = ValueOf(EstimatePoses(flight, {}));
    ASSERT_EQ(posed.photos.size(), 6u);
    for (const PosedPhoto& photo : posed.photos) {
      EXPECT_NEAR(photo.height_above_ground_m, 78.2, 0.5);
      EXPECT_NEAR(photo.cam_from_enu.TargetOriginInSource().z() - posed.ground_z_in_enu_m, 78.2, 0.5);
    }
    EXPECT_THAT(InWords(AssumptionsByPoses(posed.assumptions)), Contains(HasSubstr("78 m is assumed")));
  }
}

TEST(EstimatePoses, TakesSurveyedHeightsAgainstEachOtherAndTheBarometerForTheirZero) {
  Flight flight = FlightOf(PhotosEvery2s(5));
  for (int k = 0; k < 5; ++k) {
    Photo& photo = flight.photos[static_cast<std::size_t>(k)];
    flight::RecordedPosition& position = StandAt({kField.lat_deg + 1e-4 * k, kField.lon_deg}, photo);
    position.height_ellipsoid_m = 510.0 + 0.1 * k;
    position.is_rtk_fixed = true;
    position.height_above_takeoff_m = 60.0 + 0.1 * k + (k % 2 == 0 ? 0.4 : -0.4);  // a barometer's wander
  }
  const auto posed = ValueOf(Estimate(flight));
  for (std::size_t k = 1; k < 5; ++k) {
    EXPECT_NEAR(posed.photos.at(k).height_above_ground_m - posed.photos.at(0).height_above_ground_m,
                0.1 * static_cast<double>(k), 0.01);
  }
  EXPECT_NEAR(posed.photos.at(0).height_above_ground_m, 60.0, 0.5);
}

TEST(EstimatePoses, SaysWhatToDoWhereNothingPlacesThePhotos) {
  Flight flight = FlightOf(PhotosEvery2s(3));
  EXPECT_THAT(ErrorOf(Estimate(flight)).message, HasSubstr("flight log"));
}

class Slope final : public geo::DemSource {
 public:
  // 100 m above the sea at the field, rising by 5 % to the north.
  std::optional<double> GroundHeightM(const geo::LatLon& at) const override {
    return 100.0 + 0.05 * (at.lat_deg - kField.lat_deg) * 111200.0;
  }
};

// What such photos show may place them all the same.
TEST(EstimatePoses, HandsOnPhotosThatNoMapCanBeDrawnWithWhereTheyWereRecorded) {
  Flight flight = FlightOf(PhotosEvery2s(8));
  for (std::size_t k = 0; k < flight.photos.size(); ++k) {
    const geo::LatLon at = TruePlaceAt(TimeOf(static_cast<int>(k)));
    StandAt({k == 5 ? -at.lat_deg : at.lat_deg, at.lon_deg}, flight.photos[k]);
    if (k == 3) flight.photos[k].position->height_above_takeoff_m = 6000.0;
  }
  EstimatePosesOptions options;
  const auto refused = ValueOf(EstimatePoses(flight, options));
  EXPECT_EQ(refused.photos.size(), 6U);
  EXPECT_TRUE(refused.unplaced.empty());
  options.keep_unplaced = true;
  const auto posed = ValueOf(EstimatePoses(flight, options));
  EXPECT_EQ(posed.photos.size(), 6U);
  ASSERT_EQ(posed.unplaced.size(), 2U);
  EXPECT_EQ(posed.unplaced[0].name + ", " + posed.unplaced[1].name, "IMG_5.JPG, IMG_3.JPG");
  ASSERT_EQ(posed.left_out.size(), 2U);
  EXPECT_THAT(InWords(posed.left_out[1].reason), HasSubstr("km away"));
  EXPECT_THAT(InWords(posed.left_out[0].reason), HasSubstr("times as much ground"));
  for (Photo& photo : flight.photos) photo.intrinsics = camera::Intrinsics::Centered(4000, 3000, 1.0);
  flight.warnings.push_back("The card was nearly full.");
  const auto none = ValueOf(EstimatePoses(flight, options));
  EXPECT_EQ(none.unplaced.size(), 8U);
  EXPECT_THAT(none.warnings, Contains(flight.warnings[0]).Times(1)) << "what reading said";
}

TEST(EstimatePoses, CountsHeightsFromTheElevationModel) {
  Flight flight = FlightOf(PhotosEvery2s(10), {Track(0.0, 60.0)});
  const Slope dem;
  EstimatePosesOptions options;
  options.dem = &dem;
  for (const bool is_surveyed : {false, true}) {
    for (int k = 0; k < 10 && is_surveyed; ++k) {
      const geo::LatLon at = TruePlaceAt(TimeOf(k));
      flight::RecordedPosition& own = StandAt(at, flight.photos[static_cast<std::size_t>(k)]);
      own.height_ellipsoid_m = kGroundM + 60.0;
      own.is_rtk_fixed = true;
    }
    const auto posed = ValueOf(Estimate(flight, options));
    EXPECT_EQ(posed.report.photos_by_log, is_surveyed ? 0 : 10);
    for (int k = 0; k < 10; ++k) {
      const double t = TimeOf(k);
      EXPECT_NEAR(posed.photos.at(static_cast<std::size_t>(k)).height_above_ground_m, 60.0 - 0.05 * 8.0 * t,
                  0.6);
    }
    EXPECT_NEAR(posed.ground_z_in_enu_m, 0.05 * 8.0 * 30.0, 3.0);
    EXPECT_THAT(posed.report.height_rule, HasSubstr("elevation model"));
  }
}

TEST(EstimatePoses, TakesAbsoluteHeightsOverTheElevationModelWhereNoneIsRelative) {
  Flight flight = FlightOf(PhotosEvery2s(4));
  for (int k = 0; k < 4; ++k) {
    Photo& photo = flight.photos[static_cast<std::size_t>(k)];
    photo.position.emplace();
    photo.position->position = {kField.lat_deg, kField.lon_deg + 1e-4 * k};
    photo.position->height_amsl_m = 170.0;
  }
  const Slope dem;
  EstimatePosesOptions options;
  options.dem = &dem;
  EXPECT_NEAR(ValueOf(Estimate(flight, options)).photos.at(0).height_above_ground_m, 70.0, 0.5);
}

TEST(JoinLogs, LaysLogsOnOneClockAndFillsWhatTheLeaderLacks) {
  FlightLog inertial = Track(0.0, 60.0, 5.0);
  inertial.file_name = "a.bin";
  inertial.baro.clear();
  inertial.imu.push_back({1.0, {}, {}});
  FlightLog other = Track(0.0, 60.0, -7.0);
  other.file_name = "b.csv";
  other.attitude.clear();
  for (flight::GnssSample& fix : other.gnss) fix.is_rtk_fixed = true;
  const auto joined = test::ValueOf(JoinLogs({other, inertial}, {}));
  EXPECT_THAT(joined.notes[0], HasSubstr("a.bin"));
  EXPECT_TRUE(joined.log.gnss[0].is_rtk_fixed) << "the better track is taken";
  ASSERT_FALSE(joined.log.baro.empty());
  EXPECT_NEAR(joined.log.baro[0].t_s, -5.0, 1e-6) << "on the leader's clock";
}

TEST(JoinLogs, AppendsAnotherFlightWithItsOwnBarometersZero) {
  FlightLog first = Track(0.0, 30.0);
  FlightLog second = Track(40.0, 60.0, 40.0);
  for (flight::BaroSample& sample : second.baro) sample.height_above_takeoff_m -= 60.0;
  const auto joined = test::ValueOf(JoinLogs({first, second}, {}));
  EXPECT_NEAR(joined.log.gnss.back().t_s, 60.0, 0.3);
  EXPECT_NEAR(joined.log.baro.back().height_above_takeoff_m, 60.0, 0.1);
}

TEST(JoinLogs, RefusesLogsWhoseClocksCannotBeCompared) {
  FlightLog first = Track(0.0, 30.0);
  FlightLog second = Track(0.0, 30.0);
  second.utc_at_zero.reset();
  second.attitude.clear();
  second.file_name = "loose.csv";
  const auto joined = test::ValueOf(JoinLogs({first, second}, {}));
  EXPECT_THAT(InWords(joined.warnings), Contains(HasSubstr("loose.csv")));
}

TEST(EstimatePoses, NamesWhatWasLeftOutBeforeWhereTheRestHasNoPlace) {
  Flight flight = FlightOf(PhotosEvery2s(5));
  for (int k = 0; k < 95; ++k)
    flight.left_out.push_back({"PANO_" + std::to_string(k), ErrorCode::kUnprocessable, "A panorama."});
  const Error posed = ErrorOf(Estimate(flight));
  EXPECT_THAT(posed.message, HasSubstr("None of the files is a photo with a position"));
  EXPECT_THAT(posed.message, HasSubstr("95 of the pictures given can take no part in a map: "
                                       "PANO_0 and 94 more: A panorama."));
}

TEST(EstimatePoses, HangsTheFlightOnAGivenTakeoffHeight) {
  Flight by_records = FlightOf(PhotosEvery2s(6));
  for (int k = 0; k < 6; ++k)
    StandAt({kField.lat_deg, kField.lon_deg + 1e-4 * k}, by_records.photos[static_cast<std::size_t>(k)]);
  Flight by_log = FlightOf(PhotosEvery2s(6), {Track(0.0, 60.0)});
  EstimatePosesOptions options;
  options.takeoff_height_amsl_m = 512.0;
  for (const Flight& flight : {by_records, by_log}) {
    const auto as_recorded = Estimate(flight);
    const auto given = Estimate(flight, options);
    ASSERT_TRUE(as_recorded.ok() && given.ok());
    const geo::Wgs84 origin = given->frame.origin();
    const double geoid_m = geo::GeoidHeightM({origin.lat_deg, origin.lon_deg}).value_or(0.0);
    EXPECT_NEAR(origin.height_ellipsoid_m, 512.0 + geoid_m, 0.01);
    EXPECT_GT(std::abs(as_recorded->frame.origin().height_ellipsoid_m - origin.height_ellipsoid_m), 100.0);
    EXPECT_THAT(given->report.height_rule, HasSubstr("take-off 512.0 m above sea level, as given"));
    ASSERT_EQ(given->photos.size(), as_recorded->photos.size());
    for (std::size_t i = 0; i < given->photos.size(); ++i) {
      EXPECT_NEAR(given->photos[i].height_above_ground_m, as_recorded->photos[i].height_above_ground_m, 1e-3);
      EXPECT_NEAR((given->photos[i].cam_from_enu.TargetOriginInSource() -
                   as_recorded->photos[i].cam_from_enu.TargetOriginInSource())
                      .norm(),
                  0.0, 0.05);
    }
  }
}

}  // namespace
}  // namespace skyquilt::poses
