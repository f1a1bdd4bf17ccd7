// Which zone a camera's clock was in, and of which day photos and log are, where nothing else tells.
#include "core/poses/time/clock_zone.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <numbers>
#include <utility>

#include "core/flight/remarks/remark_words.h"
#include "core/geo/local_frame.h"
#include "core/poses/time/time_sync.h"
#include "tests/support/value_of.h"

namespace skyquilt::poses {
namespace {

using flight::FlightLog;
using flight::Photo;
using flight::UtcTime;
using test::ErrorOf;
using test::ValueOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr UtcTime kTenUtc{std::chrono::seconds(1'717'236'000)};  // 2024-06-01
constexpr double kLegS = 12.5;
constexpr int kHourS = 3600;

using PlaceAt = std::function<Eigen::Vector2d(double t_s)>;

// Legs to the north and back, 20 m apart, at 8 m/s.
Eigen::Vector2d OnLegs(double t_s) {
  const double leg = std::floor(t_s / kLegS), along_m = 8.0 * (t_s - leg * kLegS);
  return {20.0 * leg, std::fmod(std::abs(leg), 2.0) == 0.0 ? along_m : 100.0 - along_m};
}

// One position a second, counted from ten o'clock UTC.
FlightLog TrackFrom(double from_s, double until_s, const PlaceAt& place = OnLegs, FlightLog log = {}) {
  const geo::LocalFrame frame(geo::Wgs84{47.0, 8.0, 0.0});
  log.format = "gpx";
  log.file_name = "t.gpx";
  log.utc_at_zero = kTenUtc;
  for (double t_s = from_s; t_s <= until_s; t_s += 1.0) {
    const Eigen::Vector2d at = place(t_s);
    const geo::Wgs84 position = frame.Wgs84FromEnu({at.x(), at.y(), 0.0});
    flight::GnssSample sample;
    sample.t_s = t_s;
    sample.position = {position.lat_deg, position.lon_deg};
    log.gnss.push_back(sample);
  }
  return log;
}

// On legs from ten o'clock on; it was switched on before take-off.
Eigen::Vector2d StandsUntilTen(double t_s) { return t_s < 0.0 ? Eigen::Vector2d(0.0, 0.0) : OnLegs(t_s); }

Photo PhotoTakenAt(double t_s, int ahead_s) {
  Photo photo;
  photo.name = "IMG_" + std::to_string(std::lround(1000.0 + 10.0 * t_s)) + ".JPG";
  photo.captured_at =
      kTenUtc + std::chrono::milliseconds(std::llround(1000.0 * t_s)) + std::chrono::seconds(ahead_s);
  photo.captured_at_is_local = true;
  return photo;
}

// From ten seconds after ten to a hundred.
std::vector<Photo> EveryFiveSeconds(int ahead_s) {
  std::vector<Photo> photos;
  for (double t_s = 10.0; t_s <= 100.0; t_s += 5.0) photos.push_back(PhotoTakenAt(t_s, ahead_s));
  return photos;
}

// `ahead`: hours of the camera's clock, in which its photos are tied to the log.
TimeSync ExpectTied(const std::vector<Photo>& photos, const FlightLog& log, int ahead) {
  const TimeSync sync = ValueOf(MatchPhotosToLog(photos, log));
  EXPECT_NEAR(sync.camera_ahead_of_utc_s.value_or(0.0), 3600.0 * ahead, 1.0);
  return sync;
}

// The other zones are said to fit as well.
void ExpectOpen(const TimeSync& sync, const std::vector<std::string>& zones) {
  EXPECT_EQ(sync.sigma_s, kOpenClockSigmaS);
  ASSERT_THAT(sync.warnings, SizeIs(1));
  for (const std::string& zone : zones) EXPECT_THAT(InWords(sync.warnings.front()), HasSubstr(zone));
}

TEST(ChooseZone, KnowsTheHour) {
  FlightLog with_hole = TrackFrom(0.0, 120.0, OnLegs, TrackFrom(-5000.0, -4800.0));
  const std::pair<const char*, FlightLog> logs[] = {
      {"in which the aircraft flies", TrackFrom(-1300.0, 120.0, StandsUntilTen)},
      {"that is not in a hole between two logs", with_hole},
      {"that is whole", TrackFrom(-2400.0, 900.0)}};
  for (const auto& [why, log] : logs) {
    SCOPED_TRACE(why);
    const TimeSync sync = ExpectTied(EveryFiveSeconds(-5 * kHourS), log, -5);
    EXPECT_LT(sync.sigma_s, 10.0);
    EXPECT_THAT(sync.warnings, IsEmpty());
  }
}

TEST(MatchPhotosToLog, SaysThatAClockOfUtcMayBeOff) {
  const auto utc = [](std::vector<Photo> photos) {
    for (Photo& photo : photos) photo.captured_at_is_local = false;
    return photos;
  };
  const FlightLog log =
      TrackFrom(-10.0, 118.0, [](double t_s) { return OnLegs(std::clamp(t_s, 0.0, 105.0)); });
  EXPECT_THAT(ValueOf(MatchPhotosToLog(utc(EveryFiveSeconds(0)), log)).warnings, IsEmpty());
  // A minute fast: the last were taken after landing.
  const TimeSync fast = ValueOf(MatchPhotosToLog(utc(EveryFiveSeconds(60)), log));
  ASSERT_THAT(fast.warnings, SizeIs(1));
  EXPECT_THAT(InWords(fast.warnings.front()), HasSubstr("8 of 19 photos"));
  // A log that was cut in flight, and two flights with the log of one.
  EXPECT_THAT(ValueOf(MatchPhotosToLog(utc(EveryFiveSeconds(0)), TrackFrom(0.0, 60.0))).warnings, IsEmpty());
  std::vector<Photo> two_flights = EveryFiveSeconds(0);
  for (const Photo& photo : EveryFiveSeconds(kHourS)) {
    two_flights.push_back(photo);
    two_flights.back().name = "second_" + photo.name;
  }
  EXPECT_THAT(ValueOf(MatchPhotosToLog(utc(two_flights), log)).warnings, IsEmpty());
}

TEST(ChooseZone, SaysWhichWholeHoursFitAsWell) {
  ExpectOpen(ValueOf(MatchPhotosToLog(EveryFiveSeconds(-5 * kHourS), TrackFrom(-4000.0, 300.0))),
             {"UTC-05:00", "UTC-04:00"});
}

TEST(ChooseZone, BelievesHeadingsThatFollowTheCourse) {
  const FlightLog log = TrackFrom(
      -7200.0, 300.0, [](double t_s) { return t_s < -60.0 ? Eigen::Vector2d(0.0, 2.0 * t_s) : OnLegs(t_s); });
  std::vector<Photo> photos;
  for (int leg = 0; leg < 8; ++leg) {
    for (const double of_leg_s : {3.0, 6.0, 9.0}) {
      photos.push_back(PhotoTakenAt(kLegS * leg + of_leg_s, -5 * kHourS));
      photos.back().attitude.emplace();
      photos.back().attitude->yaw_rad = leg % 2 == 0 ? 0.0 : std::numbers::pi;
    }
  }
  const TimeSync sync = ExpectTied(photos, log, -5);
  EXPECT_THAT(sync.warnings, IsEmpty());
  EXPECT_THAT(sync.notes, ::testing::Contains(HasSubstr("headings")));
}

// Of clocks whose time zone stands in the photos.
std::vector<Photo> InWrittenZone(std::vector<Photo> photos, int zone_h = 2) {
  for (Photo& photo : photos) {
    photo.captured_at_is_local = false;
    photo.clock_minus_utc = std::chrono::hours(zone_h);
  }
  return photos;
}

TEST(MatchPhotosToLog, BelievesNoWrittenZoneByWhichTheAircraftStood) {
  const FlightLog log = TrackFrom(-4000.0, 120.0, StandsUntilTen);
  EXPECT_THAT(ExpectTied(InWrittenZone(EveryFiveSeconds(0)), log, 0).warnings, IsEmpty());
  const TimeSync sync = ExpectTied(InWrittenZone(EveryFiveSeconds(-kHourS)), log, -1);
  ASSERT_THAT(sync.warnings, SizeIs(1));
  EXPECT_THAT(InWords(sync.warnings.front()), HasSubstr("zone UTC+02:00, by which"));
  EXPECT_THAT(InWords(sync.warnings.front()), HasSubstr("taken for UTC+01:00"));
  // Where it flew then too, nothing speaks against the zone.
  const FlightLog flies = TrackFrom(-4000.0, 300.0);
  EXPECT_THAT(ExpectTied(InWrittenZone(EveryFiveSeconds(-kHourS)), flies, 0).warnings, IsEmpty());
}

// Their times are counted by one offset, so that what is right of the other camera would be moved along.
TEST(MatchPhotosToLog, BelievesAWrittenZoneByWhichAnotherCameraFlew) {
  const FlightLog log = TrackFrom(-4000.0, 120.0, StandsUntilTen);
  for (const int other_zone_h : {2, 1}) {
    std::vector<Photo> photos = InWrittenZone(EveryFiveSeconds(-kHourS));
    std::vector<Photo> others = InWrittenZone(EveryFiveSeconds(0), other_zone_h);
    others.resize(12);  // the camera of most photos finds the offset
    for (Photo& photo : others) {
      photo.name = "other_" + photo.name;
      photo.camera_key = "other";
      photos.push_back(photo);
    }
    const TimeSync sync = ExpectTied(photos, log, 0);
    EXPECT_THAT(flight::InOneLine(sync.warnings), ::testing::Not(HasSubstr("name the zone")));
  }
}

TEST(ChooseZone, KnowsWhereClocksAreHalfAnHourOff) {
  const Photo photo = PhotoTakenAt(0.0, 0);
  StampedPhotos camera;
  std::vector<double> times_s;
  for (std::size_t i = 0; i < 20; ++i) {
    camera.photo.push_back(0);
    times_s.push_back(5.0 * static_cast<double>(i));
  }
  FlightLog log;
  const geo::LocalFrame delhi(geo::Wgs84{28.6, 77.2, 0.0});
  log.utc_at_zero = kTenUtc;
  for (int t_s = -400; t_s <= 2000; ++t_s) {
    const geo::Wgs84 at = delhi.Wgs84FromEnu({0.0, 5.0 * t_s, 0.0});
    flight::GnssSample sample;
    sample.t_s = t_s;
    sample.position = {at.lat_deg, at.lon_deg};
    log.gnss.push_back(sample);
  }
  // At 5:30 ahead the photos begin at 0; at 5:00 ahead half an hour later, which the log covers too.
  const auto zone = ValueOf(ChooseZone({photo}, camera, times_s, 5.5 * kHourS, log));
  EXPECT_EQ(zone.zone_min, 330);
  EXPECT_GT(zone.fitting, 1u);
  EXPECT_THAT(zone.open_with_min, IsEmpty());
}

TEST(ChooseZone, TakesALogThatWasCutInFlight) {
  const TimeSync sync = ExpectTied(EveryFiveSeconds(2 * kHourS), TrackFrom(0.0, 62.0), 2);
  EXPECT_THAT(sync.notes, ::testing::Contains(HasSubstr("covers 12 of 19")));
}

TEST(ChooseZone, DoubtsAnHourOfALogThatWasCutWhereItStoodBefore) {
  // At -04:45 all photos would be of the start, at -05:00 most of them are of the flight.
  const FlightLog log = TrackFrom(-1300.0, 62.0, StandsUntilTen);
  ExpectOpen(ExpectTied(EveryFiveSeconds(-5 * kHourS), log, -5), {"UTC-04:45"});
}

// From ten o'clock on, of a recorder that runs from arming to landing: at rest for eight seconds, on legs, at
// rest for the last ten.
FlightLog ArmedFor(double duration_s) {
  return TrackFrom(0.0, duration_s, [duration_s](double t_s) {
    return OnLegs(std::clamp(t_s - 8.0, 0.0, duration_s - 18.0));
  });
}

TEST(ChooseZone, TakesALogBesidePhotosOfTheGround) {
  std::vector<Photo> tried_before = EveryFiveSeconds(2 * kHourS);
  tried_before.insert(tried_before.begin(), PhotoTakenAt(-60.0, 2 * kHourS));
  const TimeSync sync = ExpectTied(tried_before, ArmedFor(120.0), 2);
  EXPECT_LT(sync.sigma_s, 10.0);
  EXPECT_THAT(sync.notes, ::testing::Contains(HasSubstr("covers 19 of 20")));
  // A camera that takes a photo every two seconds, from before the start until after the landing.
  std::vector<Photo> all_the_while, beyond_the_end;
  for (double t_s = -10.0; t_s <= 206.0; t_s += 2.0) {
    all_the_while.push_back(PhotoTakenAt(t_s, 2 * kHourS));
    if (t_s >= 30.0) beyond_the_end.push_back(all_the_while.back());
  }
  ExpectTied(all_the_while, ArmedFor(200.0), 2);
  EXPECT_FALSE(MatchPhotosToLog(beyond_the_end, ArmedFor(200.0)).ok()) << "by a clock that is late";
}

TEST(ChooseZone, SaysBothSpansWhereTheClockIsWrong) {
  // Photos go on although the aircraft has landed: it is no part of a flight, the clock is wrong.
  const FlightLog landed = TrackFrom(0.0, 60.0, [](double t_s) { return OnLegs(std::min(t_s, 50.0)); });
  const Error sync = ErrorOf(MatchPhotosToLog(EveryFiveSeconds(2 * kHourS), landed));
  EXPECT_THAT(sync.message, HasSubstr("from 2024-06-01 12:00:10 to 2024-06-01 12:01:40"));
  EXPECT_THAT(sync.message, HasSubstr("2024-06-01 10:00:00 to 2024-06-01 10:01:00"));
}

// As many events as photos, in the same rhythm.
struct RepeatedMission {
  std::vector<Photo> photos;
  FlightLog log;
};

RepeatedMission MissionFlownAgain(std::chrono::seconds log_later, std::chrono::seconds receiver_later) {
  RepeatedMission mission;
  mission.log.file_name = "a.MRK";
  mission.log.utc_at_zero = kTenUtc + log_later;
  for (const double t_s : {3.0, 8.3, 15.1, 19.9, 27.4, 33.3}) {
    mission.photos.push_back(PhotoTakenAt(t_s, 0));
    mission.photos.back().captured_at_is_local = false;
    mission.photos.back().receiver_time = *mission.photos.back().captured_at + receiver_later;
    flight::CameraEvent event;
    event.t_s = t_s;
    event.position = geo::LatLon{47.0, 8.0 + 1e-5 * t_s};
    mission.log.events.push_back(event);
  }
  return mission;
}

TEST(MatchPhotosToLog, RefusesALogOfAnotherDayThanTheReceiversTime) {
  using std::chrono::seconds;
  constexpr seconds kWeek{7 * 86400};
  const RepeatedMission week = MissionFlownAgain(-kWeek - seconds(3333), seconds(0));
  const Error other = test::ErrorOf(MatchPhotosToLog(week.photos, week.log));
  EXPECT_THAT(other.message, HasSubstr("2024-06-01 10:00:03"));
  EXPECT_THAT(other.message, HasSubstr("2024-05-25 09:04:30"));
  // Leap seconds, a zone that the log does not name, and weeks that ran over are no other day.
  for (const RepeatedMission& same :
       {MissionFlownAgain(seconds(18), seconds(0)), MissionFlownAgain(seconds(7200), seconds(0)),
        MissionFlownAgain(seconds(0), -1024 * kWeek)})
    EXPECT_TRUE(MatchPhotosToLog(same.photos, same.log).ok());
  // The camera's clock alone may be of any day.
  RepeatedMission unknown = week;
  for (Photo& photo : unknown.photos) photo.receiver_time.reset();
  EXPECT_TRUE(MatchPhotosToLog(unknown.photos, unknown.log).ok());
  // A list that names the photos, and that nothing else contradicted, is used with the doubt.
  RepeatedMission named = week;
  for (std::size_t i = 0; i < named.photos.size(); ++i) named.log.events[i].image_name = named.photos[i].name;
  EXPECT_TRUE(MatchPhotosToLog(named.photos, named.log).ok());
  for (flight::CameraEvent& event : named.log.events) event.position.reset();
  EXPECT_FALSE(MatchPhotosToLog(named.photos, named.log).ok()) << "refused";
}

}  // namespace
}  // namespace skyquilt::poses
