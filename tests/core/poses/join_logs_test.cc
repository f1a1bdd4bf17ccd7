// Logs beside each other: tables without UTC that count the same seconds, and what of a file is not used,
// said.
#include "core/poses/time/join_logs.h"

#include <gmock/gmock.h>

#include <chrono>
#include <cmath>

#include "core/flight/logs/log_builder.h"
#include "core/flight/remarks/remark_words.h"
#include "core/poses/conventions/attitude_convention.h"
#include "core/poses/estimate_poses.h"
#include "tests/support/value_of.h"

namespace skyquilt::poses {
namespace {

using flight::FlightLog;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr geo::LatLon kMeadow{47.4, 8.5};

// North at 8 m/s, 60 m above where it began; the table counts from `counter_s`.
FlightLog Gnss(double counter_s) {
  FlightLog log;
  log.format = "tolerant_csv";
  log.file_name = "gnss.csv";
  log.counter_at_zero_s = counter_s;
  const geo::LocalFrame frame({kMeadow.lat_deg, kMeadow.lon_deg, 0.0});
  for (int i = 0; i <= 300; ++i) {
    flight::GnssSample fix;
    fix.t_s = 0.2 * i;
    const bool stands = fix.t_s < 5.0;
    const geo::Wgs84 at = frame.Wgs84FromEnu({0.0, stands ? 0.0 : 8.0 * (fix.t_s - 5.0), 0.0});
    fix.position = {at.lat_deg, at.lon_deg};
    fix.height_amsl_m = stands ? 500.0 : 560.0;
    log.gnss.push_back(fix);
  }
  return log;
}

FlightLog Triggers(double counter_s, double first_s = 20.0) {
  FlightLog log;
  log.format = "tolerant_csv";
  log.file_name = "triggers.csv";
  log.counter_at_zero_s = counter_s + first_s;
  for (int i = 0; i < 10; ++i) {
    flight::CameraEvent event;
    event.t_s = 2.0 * i;
    event.image_name = "IMG_" + std::to_string(i) + ".JPG";
    log.events.push_back(event);
  }
  return log;
}

JoinedLog Joined(const std::vector<FlightLog>& logs, const std::vector<flight::Photo>& photos = {}) {
  return JoinLogs(logs, photos).value();
}

TEST(JoinLogs, LaysTablesThatCountTheSameSecondsOnOneClock) {
  const JoinedLog joined = Joined({Triggers(1000.0), Gnss(1000.0)});
  EXPECT_THAT(joined.warnings, IsEmpty());
  EXPECT_THAT(joined.notes, Contains(HasSubstr("its times being those that gnss.csv counts")));
  ASSERT_EQ(joined.log.events.size(), 10u);
  EXPECT_NEAR(joined.log.events[1].t_s, 22.0, 1e-9) << "on the clock of gnss.csv";
}

TEST(JoinLogs, SaysWhenTwoTablesCountDifferently) {
  const JoinedLog joined = Joined({Gnss(1000.0), Triggers(5.0)});
  EXPECT_THAT(joined.log.events, IsEmpty());
  EXPECT_THAT(InWords(joined.warnings),
              Contains(HasSubstr("its times (25.0 to 43.0 s) are not those of gnss.csv")));
}

TEST(JoinLogs, DoesNotTakeTwoTracksForOneClock) {
  FlightLog other = Gnss(1000.0);
  other.file_name = "other.csv";
  const JoinedLog joined = Joined({Gnss(1000.0), other});
  EXPECT_THAT(InWords(joined.warnings), Contains(HasSubstr("other.csv is not used")));
}

TEST(JoinLogs, PrefersEventsThatNameThePhotos) {
  FlightLog numbered = Gnss(1000.0);
  for (int i = 0; i < 10; ++i) {
    flight::CameraEvent event;
    event.t_s = 20.0 + 2.0 * i;
    event.sequence = i;
    numbered.events.push_back(event);
  }
  const JoinedLog joined = Joined({numbered, Triggers(1000.0)});
  EXPECT_TRUE(joined.log.events.front().image_name);
}

TEST(JoinLogs, SaysWhatAddsNothing) {
  FlightLog leader = Gnss(0.0), second = Gnss(0.0);
  leader.utc_at_zero = second.utc_at_zero = flight::UtcTime(std::chrono::seconds(1717243200));
  second.file_name = "second.csv";
  const JoinedLog joined = Joined({leader, second});
  EXPECT_THAT(InWords(joined.warnings), Contains(HasSubstr("second.csv is not used")));
}

constexpr flight::UtcTime kAtZero{std::chrono::seconds(1717243200)};

// Ten exposures from `first_s` on, as a list beside a track has them.
FlightLog ListedFrom(double first_s, bool is_surveyed) {
  FlightLog log = Triggers(0.0, first_s);
  log.file_name = std::to_string(static_cast<int>(first_s)) + ".MRK";
  log.utc_at_zero = kAtZero + std::chrono::seconds(static_cast<int>(first_s));
  for (flight::CameraEvent& event : log.events) {
    event.image_name.reset();
    event.position = kMeadow;
    event.is_rtk_fixed = is_surveyed;
  }
  return log;
}

TEST(JoinLogs, TakesSurveyedEventsInThePlaceOfTheLogsOwn) {
  FlightLog leader = Gnss(0.0);
  leader.utc_at_zero = kAtZero;
  leader.events = ListedFrom(0.0, false).events;
  for (flight::CameraEvent& event : leader.events) event.t_s += 20.1;
  const JoinedLog joined = Joined({leader, ListedFrom(20.0, true)});
  ASSERT_EQ(joined.log.events.size(), 10u);
  for (const flight::CameraEvent& event : joined.log.events) EXPECT_TRUE(event.is_rtk_fixed);
  EXPECT_NEAR(joined.log.events.front().t_s, 20.0, 1e-9);
  // What the log has already, and no better.
  const JoinedLog same = Joined({leader, ListedFrom(20.0, false)});
  EXPECT_EQ(same.log.events.size(), 10u);
  EXPECT_THAT(InWords(same.warnings), Contains(HasSubstr("20.MRK is not used")));
}

TEST(JoinLogs, KeepsTheLogsOwnEventsWhereNoSurveyedListReaches) {
  FlightLog leader = Gnss(0.0);
  leader.utc_at_zero = kAtZero;
  leader.events = ListedFrom(0.0, false).events;
  const std::vector<flight::CameraEvent> first = leader.events;
  for (flight::CameraEvent event : first) {
    event.t_s += 200.0;
    leader.events.push_back(event);
  }
  const auto fixed = [](const FlightLog& log) {
    return std::count_if(log.events.begin(), log.events.end(), [](const auto& e) { return e.is_rtk_fixed; });
  };
  const JoinedLog one = Joined({leader, ListedFrom(0.0, true)});
  EXPECT_EQ(one.log.events.size(), 20u);
  EXPECT_EQ(fixed(one.log), 10);
  const JoinedLog both = Joined({leader, ListedFrom(0.0, true), ListedFrom(200.0, true)});
  EXPECT_EQ(both.log.events.size(), 20u);
  EXPECT_EQ(fixed(both.log), 20);
}

TEST(JoinLogs, TakesListsOfTwoPartsBesideOneTrack) {
  FlightLog track = Gnss(0.0);
  track.utc_at_zero = kAtZero;
  const JoinedLog joined = Joined({track, ListedFrom(5.0, true), ListedFrom(30.0, true)});
  EXPECT_EQ(joined.log.events.size(), 20u);
  EXPECT_THAT(joined.warnings, IsEmpty());
}

std::vector<flight::Photo> PhotosEveryFourSeconds() {
  std::vector<flight::Photo> photos(11);
  for (std::size_t i = 0; i < photos.size(); ++i)
    photos[i].captured_at = kAtZero + std::chrono::seconds(10 + 4 * i);
  return photos;
}

FlightLog TrackNamed(const std::string& name) {
  FlightLog track = Gnss(0.0);
  track.file_name = name;
  track.utc_at_zero = kAtZero;
  return track;
}

TEST(JoinLogs, TakesTheTrackThatMovesWhilePhotosAreTaken) {
  // A base station beside the start, named before the aircraft's receiver.
  FlightLog base = TrackNamed("base.pos");
  for (flight::GnssSample& sample : base.gnss) {
    sample.position = kMeadow;
    sample.is_rtk_fixed = true;
  }
  const JoinedLog joined = Joined({base, TrackNamed("rover.pos")}, PhotosEveryFourSeconds());
  EXPECT_EQ(joined.log.file_name, "rover.pos");
  EXPECT_GT(joined.log.gnss.back().position.lat_deg, kMeadow.lat_deg + 1e-3);
  EXPECT_THAT(InWords(joined.warnings), Contains(HasSubstr("base.pos, which stands still")));
}

TEST(JoinLogs, TakesTheTrackThatLiesWherePhotosWere) {
  FlightLog beside = TrackNamed("a.gpx");
  for (flight::GnssSample& sample : beside.gnss) sample.position.lon_deg += 0.002;
  const FlightLog right = TrackNamed("b.gpx");
  std::vector<flight::Photo> photos = PhotosEveryFourSeconds();
  // Two positions: the clocks tie, and the positions choose.
  for (const std::size_t i : {std::size_t{0}, photos.size() - 1}) {
    photos[i].position.emplace();
    photos[i].position->position = right.gnss[5 * (10 + 4 * i)].position;
  }
  const JoinedLog joined = Joined({beside, right}, photos);
  EXPECT_EQ(joined.log.file_name, "b.gpx");
  EXPECT_THAT(InWords(joined.warnings), Contains(HasSubstr("farther from the photos' own positions")));
}

TEST(JoinLogs, TakesNoListOfAnotherDay) {
  FlightLog last_week = ListedFrom(20.0, true);
  *last_week.utc_at_zero -= std::chrono::days(7);
  const JoinedLog joined = Joined({TrackNamed("t.gpx"), last_week}, PhotosEveryFourSeconds());
  EXPECT_EQ(joined.log.file_name, "t.gpx");
  EXPECT_THAT(joined.log.events, IsEmpty());
  EXPECT_THAT(InWords(joined.warnings), Contains(HasSubstr("20.MRK is not used: it begins at 2024-05-25")));
}

flight::Flight PhotosWithoutPositions(int count) {
  flight::Flight flight;
  for (int k = 0; k < count; ++k) {
    flight::Photo photo;
    photo.name = "IMG_" + std::to_string(k) + ".JPG";
    photo.intrinsics = camera::Intrinsics::Centered(4000, 3000, 3665.0);
    flight.photos.push_back(photo);
  }
  return flight;
}

TEST(EstimatePoses, PlacesPhotosByATrackAndATableOfExposures) {
  flight::Flight flight = PhotosWithoutPositions(10);
  flight.logs = {Gnss(1000.0), Triggers(1000.0)};
  const auto posed = test::ValueOf(EstimatePoses(flight, {}));
  ASSERT_EQ(posed.photos.size(), 10u);
  EXPECT_TRUE(posed.is_placed);
  const Eigen::Vector3d first = posed.photos[0].cam_from_enu.TargetOriginInSource();
  for (std::size_t k = 1; k < 10; ++k) {
    const Eigen::Vector3d at = posed.photos[k].cam_from_enu.TargetOriginInSource();
    EXPECT_NEAR(at.y() - first.y(), 16.0 * static_cast<double>(k), 1.0);
    EXPECT_NEAR(posed.photos[k].height_above_ground_m, 60.0, 5.0);
  }
}

TEST(EstimatePoses, PutsCorrectedPositionsOfPhotosBeforeAPlainTrack) {
  flight::Flight flight = PhotosWithoutPositions(10);
  FlightLog track = Gnss(1000.0);
  for (const flight::GnssSample& fix : track.gnss) {
    track.baro.push_back({fix.t_s, fix.t_s < 5.0 ? 0.0 : 60.0});
    track.attitude.push_back({fix.t_s, flight::NedFromYawPitchRoll(0.3, -0.1, 0.0), true});
  }
  flight.logs = {track, Triggers(1000.0)};
  // 1.5 m east of the track.
  const auto place = [](std::size_t k) {
    const double north_m = 120.0 + 16.0 * static_cast<double>(k);
    return geo::LatLon{kMeadow.lat_deg + north_m / 111'200.0, kMeadow.lon_deg + 2e-5};
  };
  for (std::size_t k = 0; k < 10; ++k) {
    flight::RecordedPosition& own = flight.photos[k].position.emplace();
    own.position = place(k);
    own.height_ellipsoid_m = 570.0;
    own.sigma_horizontal_m = 0.02;
    own.is_rtk_fixed = true;
    own.source = "ppk.csv";
  }
  const auto posed = test::ValueOf(EstimatePoses(flight, {}));
  ASSERT_EQ(posed.photos.size(), 10u);
  EXPECT_NEAR(posed.frame.origin().height_ellipsoid_m, 510.0, 1e-6) << "by the log's barometer";
  for (std::size_t k = 0; k < 10; ++k) {
    const PosedPhoto& photo = posed.photos[k];
    const geo::Wgs84 at = posed.frame.Wgs84FromEnu(photo.cam_from_enu.TargetOriginInSource());
    EXPECT_NEAR(at.lat_deg, place(k).lat_deg, 1e-8);
    EXPECT_NEAR(at.lon_deg, place(k).lon_deg, 1e-8);
    EXPECT_LT(std::sqrt(photo.covariance(3, 3)), 0.03);
    EXPECT_EQ(photo.position_source, "ppk.csv");
    ASSERT_TRUE(photo.photo.attitude);
    EXPECT_NEAR(photo.photo.attitude->yaw_rad, 0.3, 1e-9) << "the airframe's";
    ASSERT_TRUE(photo.velocity_in_enu_mps);
    EXPECT_NEAR(photo.velocity_in_enu_mps->y(), 8.0, 0.01) << "by its track";
  }
  flight::Flight with_others = flight;  // photos that only the track places
  for (std::size_t k = 7; k < 10; ++k) with_others.photos[k].position.reset();
  for (flight::GnssSample& fix : with_others.logs[0].gnss)
    fix.velocity_in_ned_mps = Eigen::Vector3d(fix.t_s < 5.0 ? 0.0 : 7.5, 0.0, 0.0);
  const auto mixed = test::ValueOf(EstimatePoses(with_others, {}));
  EXPECT_EQ(mixed.report.photos_by_log, 3);
  EXPECT_THAT(mixed.report.logs,
              Contains(HasSubstr("gives way to the corrected positions; 3 of 10 photos placed")));
  ASSERT_TRUE(mixed.photos[6].velocity_in_enu_mps);
  EXPECT_NEAR(mixed.photos[6].velocity_in_enu_mps->y(), 7.5, 1e-9) << "by its receiver";
  EXPECT_NEAR(mixed.frame.origin().height_ellipsoid_m, 510.0, 1e-6) << "by the corrected heights";
  for (flight::Photo& photo : flight.photos) photo.position->is_rtk_fixed = false;
  EXPECT_EQ(test::ValueOf(EstimatePoses(flight, {})).photos[0].position_source, "gnss.csv");
}

// A log of two parts, the one between them missing: of ten photos from 20 to 200 s two are beside the first.
flight::Flight PhotosInAHole() {
  flight::Flight flight = PhotosWithoutPositions(10);
  FlightLog track = Gnss(1000.0), exposures = Triggers(1000.0);
  std::erase_if(track.gnss, [](const auto& fix) { return fix.t_s > 21.0 && fix.t_s < 45.0; });
  for (flight::GnssSample& fix : track.gnss) {
    if (fix.t_s > 21.0) fix.t_s += 200.0;
  }
  for (flight::CameraEvent& event : exposures.events) event.t_s *= 10.0;
  flight.logs = {track, exposures};
  for (std::size_t k = 2; k < 9; ++k) {
    flight::RecordedPosition& own = flight.photos[k].position.emplace();
    own.position = {kMeadow.lat_deg + 1e-4 * static_cast<double>(k), kMeadow.lon_deg + 4e-3};
    own.height_above_takeoff_m = 55.0;
    own.source = "EXIF";
  }
  return flight;
}

TEST(EstimatePoses, LeavesPhotosInAHoleOfTheLogToWhatTheyRecord) {
  const auto posed = test::ValueOf(EstimatePoses(PhotosInAHole(), {}));
  EXPECT_EQ(posed.report.photos_by_log, 2) << "one of them a little beyond the first part";
  EXPECT_EQ(posed.report.photos_by_records, 7);
  ASSERT_EQ(posed.photos.size(), 9u);
  for (const PosedPhoto& photo : posed.photos) {
    if (!photo.photo.position) continue;
    EXPECT_EQ(photo.position_source, "EXIF");
    const geo::Wgs84 at = posed.frame.Wgs84FromEnu(photo.cam_from_enu.TargetOriginInSource());
    EXPECT_NEAR(at.lon_deg, kMeadow.lon_deg + 4e-3, 1e-7);
  }
  ASSERT_EQ(posed.left_out.size(), 1u);
  EXPECT_EQ(posed.left_out[0].name, "IMG_9.JPG") << "far from either part, and without a place of its own";
}

TEST(EstimatePoses, KeepsTheOrderOfCaptureBesideALog) {
  flight::Flight flight = PhotosInAHole();
  flight.logs[1].events[0].t_s = -100.0;  // before the log begins
  flight.logs[1].events[1].t_s = -5.0;
  flight.logs[1].events[2].t_s = 0.0;
  flight.photos[0].position = flight.photos[2].position;
  flight.photos[0].position->position.lat_deg -= 2e-4;
  const auto posed = test::ValueOf(EstimatePoses(flight, {}));
  EXPECT_EQ(posed.report.photos_by_log, 2);
  ASSERT_EQ(posed.photos.size(), 9u);
  for (std::size_t k = 0; k < 9; ++k) EXPECT_EQ(posed.photos[k].photo.name, flight.photos[k].name);
  EXPECT_GT(posed.photos[1].covariance_with_next.norm(), 0.0) << "still one after the other on the log";
  EXPECT_EQ(posed.photos[2].covariance_with_next.norm(), 0.0);
}

TEST(EstimatePoses, CountsAbsoluteHeightsBesideALogFromItsZero) {
  flight::Flight flight = PhotosInAHole();
  for (std::size_t k = 2; k < 9; ++k) {
    flight.photos[k].position->height_above_takeoff_m.reset();
    flight.photos[k].position->height_amsl_m = 500.0 + 40.0 + static_cast<double>(k);
  }
  const auto posed = test::ValueOf(EstimatePoses(flight, {}));
  EXPECT_EQ(posed.report.photos_by_records, 7);
  for (const Assumption& one : posed.assumptions) EXPECT_FALSE(one.height_above_ground_m);
  for (const PosedPhoto& photo : posed.photos) {
    if (!photo.photo.position) continue;
    EXPECT_NEAR(photo.height_above_ground_m, *photo.photo.position->height_amsl_m - 500.0, 1.0);
  }
}

TEST(EstimatePoses, SaysWhichFilesPlacedNothing) {
  flight::Flight flight = PhotosWithoutPositions(3);
  for (flight::Photo& photo : flight.photos) {
    photo.position.emplace();
    photo.position->position = kMeadow;
    photo.position->height_above_takeoff_m = 60.0;
    photo.captured_at = flight::UtcTime(std::chrono::seconds(1717243200));
  }
  FlightLog rows;
  rows.format = "geo_txt";
  rows.file_name = "geo.txt";
  rows.events.resize(1);
  rows.events[0].has_time = false;
  rows.events[0].image_name = "DSC_7.JPG";
  rows.events[0].position = kMeadow;
  FlightLog empty;
  empty.format = "tolerant_csv";
  empty.file_name = "empty.csv";
  FlightLog earlier = Gnss(0.0);
  earlier.file_name = "earlier.csv";
  for (int i = 0; i < 3; ++i) {
    flight::CameraEvent event;
    event.t_s = -100.0 + i;
    event.image_name = "IMG_" + std::to_string(i) + ".JPG";
    earlier.events.push_back(event);
  }
  flight.logs = {rows, empty, earlier};
  const auto posed = test::ValueOf(EstimatePoses(flight, {}));
  EXPECT_THAT(InWords(posed.warnings), Contains(HasSubstr("geo.txt is not used: its rows name 1 photo ")));
  EXPECT_THAT(InWords(posed.warnings), Contains(HasSubstr("empty.csv is not used")));
  EXPECT_THAT(InWords(posed.warnings),
              Contains(HasSubstr("earlier.csv is not used: none of the photos was taken")));
}

}  // namespace
}  // namespace skyquilt::poses
