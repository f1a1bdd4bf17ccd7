#include "api/common/feature_query.h"

#include <gtest/gtest.h>

namespace skyquilt::api {
namespace {

TEST(UtcOfCapture, GivesClocksWithoutAZoneThatOfTheirLongitude) {
  EXPECT_EQ(UtcOfCapture("2024-06-01T10:00:00", 15.2), "2024-06-01T09:00:00Z");
  EXPECT_EQ(UtcOfCapture("2024-06-01T20:30:00.250", -74.0), "2024-06-02T01:30:00.250Z");
  EXPECT_EQ(UtcOfCapture("2024-03-01T00:10:00", 172.6), "2024-02-29T12:10:00Z");
  EXPECT_EQ(UtcOfCapture("2024-06-01T10:00:00", -0.1), "2024-06-01T10:00:00Z");
}

TEST(UtcOfCapture, LeavesWhatIsInUtc) {
  EXPECT_EQ(UtcOfCapture("2024-06-01T10:00:00Z", 100.0), "2024-06-01T10:00:00Z");
  EXPECT_EQ(UtcOfCapture("2024-06-01T10:00:00.5Z", 100.0), "2024-06-01T10:00:00.5Z");
}

TEST(UtcOfCapture, TakesTheZoneThatIsWritten) {
  EXPECT_EQ(UtcOfCapture("2024-06-01T10:00:00+02:00", -100.0), "2024-06-01T08:00:00Z");
  EXPECT_EQ(UtcOfCapture("2015-10-27T21:31:02.5-04:30", 0.0), "2015-10-28T02:01:02.5Z");
}

TEST(InstantOf, ReadsRfc3339ToTheMicrosecond) {
  const auto noon = InstantOf("2024-06-01T12:00:00Z");
  ASSERT_TRUE(noon);
  EXPECT_EQ(InstantOf("2024-06-01T14:00:00+02:00"), noon);
  EXPECT_EQ(InstantOf("2024-06-01t12:00:00.25z"), *noon + std::chrono::milliseconds(250));
  EXPECT_EQ(InstantOf("2024-06-01T12:00:00.0000019Z"), *noon + std::chrono::microseconds(1));
  for (const char* text : {"", "2024-06-01", "2024-06-01T12:00:00", "2024-06-01T12:00:00+2:00", "..",
                           "2024-06-01T12:00:00+25:00", "2024-06-01T12:00:00ZZ"}) {
    EXPECT_FALSE(InstantOf(text)) << text;
  }
}

TEST(UtcOfCapture, RefusesWhatIsNoTime) {
  for (const char* text :
       {"", "2024", "2024-06-01 10:00:00", "2024-13-01T10:00:00", "2024-02-30T10:00:00",
        "2024-06-01T24:00:00", "2024-06-01T10:61:00", "2024-06-01T10:00:-1", "2024-06-01T10:00:00.",
        "2024-06-01T10:00:00x", "2024-06-01T10:00:00.xZ", "20a4-06-01T10:00:00"}) {
    EXPECT_FALSE(UtcOfCapture(text, 10.0)) << text;
  }
}

}  // namespace
}  // namespace skyquilt::api
