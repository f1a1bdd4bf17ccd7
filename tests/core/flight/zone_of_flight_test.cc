// The zone of the cameras' clocks by GPS times that name no day: told by most photos of a flight, never photo
// by photo.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstddef>

#include "core/flight/metadata/capture_time.h"
#include "core/flight/photos/read_photo.h"
#include "core/flight/read_flight.h"
#include "tests/core/flight/synthetic_photo.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/value_of.h"

namespace skyquilt::flight {
namespace {

using namespace std::chrono_literals;
using std::chrono::microseconds;

constexpr std::chrono::year_month_day kDay(std::chrono::year(2021), std::chrono::month(6),
                                           std::chrono::day(3));

// Taken at a time of that day by the camera's clock, of unknown zone, and of any day by the receiver.
Photo TakenAt(microseconds by_clock, microseconds by_receiver) {
  Photo photo;
  photo.captured_at = UtcTime(std::chrono::sys_days(kDay)) + by_clock;
  photo.captured_at_is_local = true;
  photo.receiver_time_of_day = by_receiver;
  return photo;
}

// So many photos, a minute apart, of a clock two hours ahead of UTC that is off by as much as is said.
std::vector<Photo> TwoHoursAhead(const std::vector<microseconds>& off_by) {
  std::vector<Photo> photos;
  for (std::size_t i = 0; i < off_by.size(); ++i) {
    const microseconds utc = 10h + std::chrono::minutes(i);
    photos.push_back(TakenAt(utc + 2h + off_by[i], utc));
  }
  return photos;
}

std::ptrdiff_t LocalOf(const std::vector<Photo>& photos) {
  return std::count_if(photos.begin(), photos.end(),
                       [](const Photo& photo) { return photo.captured_at_is_local; });
}

TEST(TakeZoneOfFlight, KeepsAFlightTogetherWhoseClockIsAboutAsFarOffAsIsAllowed) {
  std::vector<Photo> most = TwoHoursAhead({4900ms, 5100ms, 4800ms, 5200ms, 4950ms});
  TakeZoneOfFlight(most);
  EXPECT_EQ(LocalOf(most), 0);
  for (const Photo& photo : most) EXPECT_EQ(photo.clock_minus_utc, 2h);
  EXPECT_EQ(most[1].captured_at, UtcTime(std::chrono::sys_days(kDay)) + 10h + 1min + 5100ms)
      << "with the steps of the camera's clock";
  EXPECT_EQ(most[1].receiver_time, UtcTime(std::chrono::sys_days(kDay)) + 10h + 1min);
  EXPECT_TRUE(std::is_sorted(most.begin(), most.end(), ComesBefore));

  std::vector<Photo> few = TwoHoursAhead({4900ms, 5100ms, 4800ms, 5200ms, 5050ms});
  TakeZoneOfFlight(few);
  EXPECT_EQ(LocalOf(few), 5) << "no zone is shown by most";
  EXPECT_TRUE(std::is_sorted(few.begin(), few.end(), ComesBefore));
  EXPECT_FALSE(few[0].receiver_time);
}

TEST(TakeZoneOfFlight, LeavesPhotosThatShowAnotherZoneTheCamerasTime) {
  std::vector<Photo> photos = TwoHoursAhead({0ms, 1s, 0ms, 45min, 6min});
  const std::vector<Photo> before = photos;
  TakeZoneOfFlight(photos);
  EXPECT_EQ(LocalOf(photos), 2);
  for (const std::size_t i : {3U, 4U}) {
    EXPECT_EQ(photos[i].captured_at, before[i].captured_at);
    EXPECT_FALSE(photos[i].clock_minus_utc);
  }
}

TEST(TakeZoneOfFlight, FindsTheDayAcrossMidnight) {
  std::vector<Photo> india{TakenAt(2h + 4min + 57s, 20h + 34min + 56s)};
  TakeZoneOfFlight(india);
  EXPECT_EQ(india[0].receiver_time, UtcTime(std::chrono::sys_days(kDay)) - 24h + 20h + 34min + 56s);
  EXPECT_EQ(india[0].clock_minus_utc, 5h + 30min);
  std::vector<Photo> hawaii{TakenAt(15h + 34min + 56s, 1h + 34min + 56s)};
  TakeZoneOfFlight(hawaii);
  EXPECT_EQ(hawaii[0].captured_at, UtcTime(std::chrono::sys_days(kDay)) + 25h + 34min + 56s);
  std::vector<Photo> odd{TakenAt(15h + 41min, 1h + 34min + 56s)};
  TakeZoneOfFlight(odd);
  EXPECT_EQ(LocalOf(odd), 1) << "the time of no zone";
}

TEST(ReadPhotoTime, TakesTheZoneOfTheFilesTimeUnlessItWasChangedLater) {
  const auto zone_of = [](const std::string& changed_at) {
    ExifWriter exif;
    exif.Ascii(ExifIfd::kImage, 0x0132, changed_at);
    exif.Ascii(ExifIfd::kExif, 0x9003, "2021:06:03 12:34:56");
    exif.Ascii(ExifIfd::kExif, 0x9010, "+01:00");
    return test::ValueOf(ReadPhotoFromBytes("a.jpg", JpegHeader({.exif = exif.Write()}))).clock_minus_utc;
  };
  EXPECT_EQ(zone_of("2021:06:03 12:34:56"), 1h);
  EXPECT_FALSE(zone_of("2021:11:20 09:00:00")) << "exported in winter";
}

// As of receivers of before 2019 that are never renewed.
TEST(ReadPhotoTime, AddsTheWeeksThatAReceiverLost) {
  ExifWriter exif;
  exif.Ascii(ExifIfd::kExif, 0x9003, "2024:06:01 12:00:00");
  exif.Ascii(ExifIfd::kGps, 0x1D, "2004:10:16").Rational(ExifIfd::kGps, 7, {{10, 1}, {0, 1}, {0, 1}});
  const Photo photo = test::ValueOf(ReadPhotoFromBytes("a.jpg", JpegHeader({.exif = exif.Write()})));
  const UtcTime in_time = std::chrono::sys_days(std::chrono::year(2024) / 6 / 1) + 10h;
  EXPECT_EQ(photo.captured_at, in_time);
  EXPECT_EQ(photo.receiver_time, in_time);
  EXPECT_EQ(photo.clock_minus_utc, 2h);
  for (const Remark& note : photo.notes) EXPECT_NE(note.code, RemarkCode::kClocksDisagree);
}

// The day of the camera's clock beside the hours of UTC.
TEST(ReadPhotoTime, FindsTheDayOfTheReceiverWhereTheClocksStandsThere) {
  const auto read = [](const std::string& clock, std::uint32_t utc_hour, std::uint32_t utc_minute) {
    ExifWriter exif;
    exif.Ascii(ExifIfd::kExif, 0x9003, "2021:06:03 " + clock);
    exif.Ascii(ExifIfd::kGps, 0x1D, "2021:06:03");
    exif.Rational(ExifIfd::kGps, 7, {{utc_hour, 1}, {utc_minute, 1}, {0, 1}});
    return test::ValueOf(ReadPhotoFromBytes("a.jpg", JpegHeader({.exif = exif.Write()})));
  };
  const UtcTime midnight = std::chrono::sys_days(kDay);
  const Photo chicago = read("19:10:01", 0, 10), sydney = read("08:00:00", 22, 0);
  EXPECT_EQ(chicago.receiver_time, midnight + 24h + 10min);
  EXPECT_EQ(chicago.captured_at, midnight + 24h + 10min + 1s);
  EXPECT_EQ(chicago.clock_minus_utc, -5h);
  for (const Remark& note : chicago.notes) EXPECT_NE(note.code, RemarkCode::kClocksDisagree);
  EXPECT_EQ(sydney.captured_at, midnight - 2h);
  EXPECT_EQ(sydney.clock_minus_utc, 10h);
  EXPECT_EQ(read("18:50:00", 23, 50).captured_at, midnight + 23h + 50min) << "before midnight of UTC";
  EXPECT_EQ(read("19:17:00", 0, 10).captured_at, midnight + 10min) << "a clock that shows no zone";
}

TEST(ReadFlight, TellsTheZoneByMostOfItsPhotos) {
  const test::TemporaryFolder folder;
  const auto write = [&](const std::string& name, const std::string& clock, std::uint32_t second) {
    ExifWriter exif;
    exif.Position(46.8 + 1e-3 * second, 7.1);
    exif.Ascii(ExifIfd::kExif, 0x9003, clock);
    exif.Rational(ExifIfd::kGps, 7, {{10, 1}, {0, 1}, {second, 1}});
    folder.Write(name, JpegHeader({.exif = exif.Write()}));
  };
  write("a.jpg", "2021:06:03 12:00:04", 0);
  write("b.jpg", "2021:06:03 12:00:16", 10);  // six seconds apart
  write("c.jpg", "2021:06:03 12:00:24", 20);
  SilentProgress progress;
  const Flight flight =
      test::ValueOf(ReadFlight(test::ValueOf(ListInputFiles({folder.path()})), 0, progress));
  ASSERT_EQ(flight.photos.size(), 3U);
  EXPECT_EQ(LocalOf(flight.photos), 0);
  EXPECT_EQ(flight.photos[1].name, "b.jpg") << "it came last, two hours later";
}

}  // namespace
}  // namespace skyquilt::flight
