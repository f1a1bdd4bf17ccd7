// When a flight was taken, by the clock on the wall there.
#include <gtest/gtest.h>

#include "core/pipeline/report/mosaic_report.h"

namespace skyquilt::pipeline {
namespace {

using namespace std::chrono;

flight::Photo At(flight::UtcTime time, std::optional<minutes> zone = {}, bool is_local = false) {
  flight::Photo photo;
  photo.captured_at = time;
  photo.captured_at_is_local = is_local;
  photo.clock_minus_utc = zone;
  return photo;
}

constexpr flight::UtcTime kEvening = sys_days(2015y / 10 / 27) + 23h + 50min + 2s + 900ms;

TEST(CaptureSpan, IsWrittenInTheZoneOfTheCamerasClock) {
  const flight::Photo late = At(kEvening + 20min, -4h), early = At(kEvening, -4h), untimed;
  const auto span = CaptureSpanOf({&late, &untimed, &early});
  ASSERT_TRUE(span);
  EXPECT_EQ(span->first, "2015-10-27T19:50:02-04:00");
  EXPECT_EQ(span->last, "2015-10-27T20:10:02-04:00");
}

TEST(CaptureSpan, TakesTheZoneOfThePhotosThatKnowIt) {
  const flight::Photo first = At(kEvening), second = At(kEvening + 20min, 5h + 30min);
  const auto span = CaptureSpanOf({&first, &second});
  EXPECT_EQ(span->first, "2015-10-28T05:20:02+05:30");
  EXPECT_EQ(span->last, "2015-10-28T05:40:02+05:30");
}

TEST(CaptureSpan, SaysWhatIsNotKnown) {
  const flight::Photo utc = At(kEvening), local = At(kEvening - 30h, {}, true), untimed;
  EXPECT_EQ(CaptureSpanOf({&utc})->first, "2015-10-27T23:50:02Z");
  EXPECT_EQ(CaptureSpanOf({&local})->first, "2015-10-26T17:50:02");
  EXPECT_EQ(CaptureSpanOf({&local, &utc})->first, "2015-10-27T23:50:02Z")
      << "UTC counts before a local clock";
  EXPECT_EQ(CaptureSpanOf({&utc, &local})->last, "2015-10-27T23:50:02Z");
  EXPECT_FALSE(CaptureSpanOf({&untimed}));
  EXPECT_FALSE(CaptureSpanOf({}));
}

}  // namespace
}  // namespace skyquilt::pipeline
