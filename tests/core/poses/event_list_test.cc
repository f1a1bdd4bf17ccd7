// Lists of positions that are those of camera events and do not say so: found by name and by rhythm, with
// rows missing or too many; and what is no such list.
#include "core/poses/time/event_list.h"

#include <gmock/gmock.h>

#include <chrono>
#include <cmath>
#include <random>
#include <string>

#include "core/geo/geodesic.h"
#include "core/poses/estimate_poses.h"
#include "core/poses/time/time_sync.h"
#include "tests/support/value_of.h"

namespace skyquilt::poses {
namespace {

using flight::FlightLog;
using flight::Photo;
using test::ErrorOf;
using test::ValueOf;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;

constexpr double kAheadS = 7400.4;  // the camera's clock
const flight::UtcTime kTakeoff =
    std::chrono::sys_days(std::chrono::year(2024) / 5 / 17) + std::chrono::hours(9);

// Exposures of a flight that slows down into its turns.
std::vector<double> Irregular(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> interval(6.0, 9.0);
  std::vector<double> times_s{4.2};
  while (times_s.size() < count)
    times_s.push_back(times_s.back() + interval(random) + (times_s.size() % 6 == 0 ? 5.0 : 0.0));
  return times_s;
}

std::vector<double> Regular(std::size_t count, double interval_s) {
  std::vector<double> times_s;
  for (std::size_t i = 0; i < count; ++i) times_s.push_back(4.2 + interval_s * static_cast<double>(i));
  return times_s;
}

// North at 5 m/s.
geo::LatLon PlaceAt(double t_s) { return {47.0 + 5.0 * t_s / 111'200.0, 8.0}; }

FlightLog ListOf(const std::vector<double>& times_s, const std::string& name) {
  FlightLog log;
  log.format = "rtklib_pos";
  log.file_name = name;
  log.utc_at_zero = kTakeoff;
  for (const double t_s : times_s) {
    flight::GnssSample row;
    row.t_s = t_s;
    row.position = PlaceAt(t_s);
    row.height_ellipsoid_m = 640.0;
    row.sigma_horizontal_m = 0.01;
    row.sigma_vertical_m = 0.02;
    row.is_rtk_fixed = true;
    log.gnss.push_back(row);
  }
  return log;
}

// Stamps cut to whole seconds.
std::vector<Photo> Exposed(const std::vector<double>& times_s) {
  std::vector<Photo> photos;
  for (const double t_s : times_s) {
    Photo photo;
    photo.name = "DJI_" + std::to_string(1000 + photos.size()) + ".JPG";
    photo.captured_at = kTakeoff + std::chrono::seconds(static_cast<std::int64_t>(std::floor(t_s + kAheadS)));
    photo.intrinsics = camera::Intrinsics::Centered(4000, 3000, 3000.0);
    photos.push_back(std::move(photo));
  }
  return photos;
}

std::vector<double> Without(std::vector<double> times_s, std::size_t row) {
  times_s.erase(times_s.begin() + static_cast<std::ptrdiff_t>(row));
  return times_s;
}

double OffM(const Photo& photo, double t_s) {
  return photo.position ? geo::MetresApart(photo.position->position, PlaceAt(t_s)) : 1e9;
}

TEST(AsEventList, KnowsAListByItsNameOrByItsRhythm) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const std::vector<double> times_s = Irregular(18, seed);
    const std::vector<Photo> photos = Exposed(times_s);
    for (const std::string name : {"raw_events.pos", "solution.pos", "20240517.csv"}) {
      for (const auto& rows : {times_s, Without(times_s, seed % 18)}) {
        const auto list = AsEventList(ListOf(rows, name), photos);
        ASSERT_TRUE(list) << name << " " << seed;
        EXPECT_TRUE(list->gnss.empty());
        ASSERT_EQ(list->events.size(), rows.size());
        EXPECT_TRUE(list->events[0].is_rtk_fixed);
      }
    }
  }
}

TEST(AsEventList, OneOfAFewRowsIsKnownByItsNameWhereItHasAsManyAsThereArePhotos) {
  for (const std::size_t count : {2u, 3u}) {
    const std::vector<double> times_s = Irregular(count, 5);
    const std::vector<Photo> photos = Exposed(times_s);
    EXPECT_FALSE(AsEventList(ListOf(times_s, "raw.pos"), photos)) << count;
    EXPECT_FALSE(AsEventList(ListOf(times_s, "raw_events.pos"), Exposed(Irregular(9, 5)))) << count;
    const auto list = AsEventList(ListOf(times_s, "raw_events.pos"), photos);
    ASSERT_TRUE(list) << count;
    const TimeSync sync = ValueOf(MatchPhotosToLog(photos, *list));
    for (std::size_t i = 0; i < count; ++i) {
      ASSERT_TRUE(sync.photos[i] && sync.photos[i]->event) << i;
      EXPECT_EQ(*sync.photos[i]->event, i);
    }
  }
}

TEST(AsEventList, LeavesTracksAndListsOfOtherFlightsAlone) {
  const std::vector<double> times_s = Irregular(40, 3);
  const std::vector<Photo> photos = Exposed(times_s);
  EXPECT_FALSE(AsEventList(ListOf(Regular(300, 1.0), "track.pos"), photos));
  EXPECT_FALSE(AsEventList(ListOf(Regular(300, 1.0), "flight_events.csv"), photos)) << "a track, named oddly";
  EXPECT_FALSE(AsEventList(ListOf(Regular(2000, 0.2), "flight_events.csv"), photos));
  EXPECT_FALSE(AsEventList(ListOf(Regular(41, 8.0), "track.pos"), photos)) << "as many, but even";
  for (unsigned seed = 100; seed < 120; ++seed)
    EXPECT_FALSE(AsEventList(ListOf(Irregular(40, seed), "other.pos"), photos)) << seed;
  EXPECT_FALSE(AsEventList(ListOf({1.0, 2.0}, "raw_events.pos"), photos)) << "too few to tell";
  EXPECT_FALSE(AsEventList(ListOf(times_s, "raw_events.pos"), {}));
  FlightLog autopilot = ListOf(times_s, "raw_events.pos");
  autopilot.imu.emplace_back();
  EXPECT_FALSE(AsEventList(autopilot, photos));
}

TEST(EstimatePoses, PlacesPhotosAtTheRowsOfAnEventList) {
  for (const std::string name : {"raw_events.pos", "solution.pos"}) {
    const std::vector<double> times_s = Irregular(18, 5);
    constexpr std::size_t kMissing = 8;
    flight::Flight flight;
    flight.photos = Exposed(times_s);
    flight.logs = {ListOf(Without(times_s, kMissing), name)};
    const auto posed = ValueOf(EstimatePoses(flight, {}));
    ASSERT_EQ(posed.photos.size(), 18u);
    for (std::size_t i = 0; i < 18; ++i) {
      if (i == kMissing) continue;
      EXPECT_LT(OffM(posed.photos[i].photo, times_s[i]), 0.01) << i;
    }
    const Photo& between = posed.photos[kMissing].photo;
    EXPECT_LT(OffM(between, times_s[kMissing]), 4.0) << "half a second at 5 m/s, and the clock";
    EXPECT_GT(*between.position->sigma_horizontal_m, 5.0);
    EXPECT_LT(*posed.photos[0].photo.position->sigma_horizontal_m, 0.1);
    EXPECT_NEAR(*posed.report.camera_ahead_of_utc_s, kAheadS, 0.5);
    EXPECT_THAT(posed.report.logs, Contains(HasSubstr("17 positions are those of camera events")));
    EXPECT_THAT(posed.report.time_match, AllOf(HasSubstr("17 of 18"), HasSubstr("1 without an event")));
  }
}

TEST(EstimatePoses, TakesAListWithARowTooManyAndOneBesideATrack) {
  const std::vector<double> times_s = Irregular(18, 6);
  flight::Flight flight;
  flight.photos = Exposed(Without(times_s, 4));
  flight.logs = {ListOf(times_s, "solution.pos"), ListOf(Regular(900, 0.2), "track.pos")};
  const auto posed = ValueOf(EstimatePoses(flight, {}));
  ASSERT_EQ(posed.photos.size(), 17u);
  const std::vector<double> of_photos_s = Without(times_s, 4);
  for (std::size_t i = 0; i < 17; ++i) EXPECT_LT(OffM(posed.photos[i].photo, of_photos_s[i]), 0.01) << i;
}

TEST(MatchPhotosToLog, RefusesToGuessWhichOfEqualIntervalsIsMissing) {
  const std::vector<double> times_s = Regular(18, 7.0);
  const std::vector<Photo> photos = Exposed(times_s);
  const auto list = ValueOf(AsEventList(ListOf(Without(times_s, 17), "raw_events.pos"), photos));
  EXPECT_THAT(ErrorOf(MatchPhotosToLog(photos, list)).message,
              AllOf(HasSubstr("18 photos"), HasSubstr("17 camera events"), HasSubstr("7.0 s")));
  // A hole in the middle is as good as an interval of its own.
  const auto holed = ValueOf(AsEventList(ListOf(Without(times_s, 9), "raw_events.pos"), photos));
  const auto found = ValueOf(MatchPhotosToLog(photos, holed));
  EXPECT_FALSE(found.photos.at(9)->event);
  EXPECT_EQ(found.photos.at(10)->event, 9u);
}

TEST(MatchPhotosToLog, LetsThePhotosOwnPositionsDecideBetweenShifts) {
  const std::vector<double> times_s = Regular(18, 7.0);
  for (const std::size_t missing : {0u, 17u}) {
    std::vector<Photo> photos = Exposed(times_s);
    for (std::size_t i = 0; i < photos.size(); ++i) {
      photos[i].position.emplace();
      photos[i].position->position = PlaceAt(times_s[i]);
      photos[i].position->position.lon_deg += i % 2 == 0 ? 3e-5 : -2e-5;  // a few metres off
    }
    const auto list = ValueOf(AsEventList(ListOf(Without(times_s, missing), "raw_events.pos"), photos));
    const auto sync = ValueOf(MatchPhotosToLog(photos, list));
    EXPECT_FALSE(sync.photos.at(missing)->event);
    EXPECT_EQ(sync.photos.at(5)->event, missing == 0 ? 4u : 5u);
    EXPECT_LT(sync.sigma_s, 0.5);
  }
}

TEST(MatchPhotosToLog, SaysTheNumbersWhereTheRhythmIsAnother) {
  const std::vector<Photo> photos = Exposed(Irregular(18, 5));
  const auto list = AsEventList(ListOf(Irregular(17, 77), "raw_events.pos"), photos);
  ASSERT_TRUE(list) << "its name says so";
  EXPECT_THAT(ErrorOf(MatchPhotosToLog(photos, *list)).message,
              AllOf(HasSubstr("18 photos"), HasSubstr("17 camera events")));
}

}  // namespace
}  // namespace skyquilt::poses
