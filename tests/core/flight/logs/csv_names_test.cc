// Tables as people write them: units behind the names in any case, tables of exposures, tables that no reader
// knows.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/flight/logs/csv/csv_columns.h"
#include "core/flight/logs/explain_unknown.h"
#include "core/flight/logs/formats.h"
#include "core/flight/logs/read_log.h"
#include "core/flight/remarks/remark_words.h"

namespace skyquilt::flight {
namespace {

using M = CsvMeaning;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(MapTolerantColumns, ReadsUnitsBehindNamesInAnyCase) {
  struct Case {
    std::string_view header;
    M meaning;
    double scale;
  };
  const double deg = 3.14159265358979323846 / 180.0;
  for (const Case& c : {Case{"lat_deg", M::kLat, 1.0},
                        Case{"LAT_DEG", M::kLat, 1.0},
                        Case{"latDeg", M::kLat, 1.0},
                        Case{"Latitude [deg]", M::kLat, 1.0},
                        Case{"LATDEG", M::kLat, 1.0},
                        Case{"lonDeg", M::kLon, 1.0},
                        Case{"longitude_degrees", M::kLon, 1.0},
                        Case{"latE7", M::kLat, 1e-7},
                        Case{"lon_rad", M::kLon, 1.0 / deg},
                        Case{"alt_m", M::kHeightAmsl, 1.0},
                        Case{"AltFt", M::kHeightAmsl, 0.3048},
                        Case{"hacc_m", M::kSigmaHorizontal, 1.0},
                        Case{"hAccMm", M::kSigmaHorizontal, 1e-3},
                        Case{"time_s", M::kTime, 1.0},
                        Case{"Time_S", M::kTime, 1.0},
                        Case{"TimeUS", M::kTime, 1e-6},
                        Case{"timestamp_ms", M::kTime, 1e-3},
                        Case{"timems", M::kTime, 1e-3},
                        Case{"gyro_x_deg_s", M::kGyroX, deg},
                        Case{"velN_m_s", M::kVelocityNorth, 1.0},
                        Case{"yaw_deg", M::kYaw, deg},
                        Case{"ts", M::kIgnored, 1.0},
                        Case{"lat_m", M::kIgnored, 1.0},
                        Case{"latest", M::kIgnored, 1.0},
                        Case{"speed_mps", M::kIgnored, 1.0}}) {
    const auto columns = MapTolerantColumns({c.header});
    ASSERT_EQ(columns.size(), 1u);
    EXPECT_EQ(columns[0].meaning, c.meaning) << c.header;
    if (c.meaning == M::kIgnored) continue;
    EXPECT_DOUBLE_EQ(columns[0].scale, c.scale) << c.header;
  }
}

TEST(ParseTolerantCsv, ReadsAGnssLogWithUnitsInItsNames) {
  const std::string text =
      "time_s,lat_deg,lon_deg,alt_m,hacc_m\n100.0,46.8,7.1,500.5,1.5\n100.2,46.800001,7.1,500.6,1.4\n";
  const auto format = RecogniseLog(BytesOf(text), "gnss.csv");
  ASSERT_TRUE(format.ok());
  ASSERT_EQ(*format, LogFormat::kTolerantCsv);
  const auto log = ParseLog("gnss.csv", BytesOf(text));
  ASSERT_TRUE(log.ok()) << log.error().message;
  ASSERT_EQ(log->gnss.size(), 2u);
  EXPECT_NEAR(log->gnss[1].t_s, 0.2, 1e-9);
  EXPECT_DOUBLE_EQ(*log->counter_at_zero_s, 100.0);
  EXPECT_DOUBLE_EQ(log->gnss[1].position.lat_deg, 46.800001);
  EXPECT_DOUBLE_EQ(*log->gnss[0].height_amsl_m, 500.5);
  EXPECT_DOUBLE_EQ(*log->gnss[0].sigma_horizontal_m, 1.5);
}

TEST(ParseTolerantCsv, ReadsATableOfExposuresByName) {
  for (const char* header : {"time_s,photo", "Time_S,Photo", "time_s,image", "time_s,filename"}) {
    const std::string text = std::string(header) + "\n103.5,IMG_1.jpg\n106.5,IMG_2.jpg\n109.75,IMG_3.jpg\n";
    const auto log = ParseLog("triggers.csv", BytesOf(text));
    ASSERT_TRUE(log.ok()) << header;
    ASSERT_EQ(log->events.size(), 3u) << header;
    EXPECT_EQ(log->events[1].image_name, "IMG_2.jpg");
    EXPECT_TRUE(log->events[1].has_time);
    EXPECT_NEAR(log->events[2].t_s + *log->counter_at_zero_s, 109.75, 1e-9) << header;
  }
}

TEST(ParseTolerantCsv, TellsSecondsOfExposuresFromMilliseconds) {
  const auto seconds = ParseLog("a.csv", BytesOf("time,photo\n10,a.jpg\n13,b.jpg\n16,c.jpg\n"));
  ASSERT_TRUE(seconds.ok());
  EXPECT_NEAR(seconds->events[2].t_s, 6.0, 1e-9);
  const auto milliseconds = ParseLog("a.csv", BytesOf("time,photo\n10000,a.jpg\n13000,b.jpg\n16000,c.jpg\n"));
  ASSERT_TRUE(milliseconds.ok());
  EXPECT_NEAR(milliseconds->events[2].t_s, 6.0, 1e-9);
}

TEST(ParseTolerantCsv, TellsNumbersOfPhotosFromFlags) {
  const auto numbers = ParseLog("a.csv", BytesOf("time_s,photo\n10,1\n13,2\n16,3\n"));
  ASSERT_TRUE(numbers.ok());
  ASSERT_EQ(numbers->events.size(), 3u);
  EXPECT_EQ(numbers->events[2].sequence, 3);
  const auto flags = ParseLog(
      "a.csv", BytesOf("time_s,lat,lon,photo\n1,46,7,0\n2,46,7,1\n3,46,7,1\n4,46,7,0\n5,46,7,true\n"));
  ASSERT_TRUE(flags.ok());
  ASSERT_EQ(flags->events.size(), 2u);
  EXPECT_FALSE(flags->events[0].image_name);
}

TEST(ParseTolerantCsv, ReadsPlacesOfNamedPhotosWithoutTimes) {
  const std::string text =
      "photo;latDeg;lonDeg;alt_m;hacc_m\nIMG_1.jpg;46.8;7.1;560;0.02\nIMG_2.jpg;46.81;7.11;561;0.02\n;46.8;7.1;1;1\n";
  const auto log = ParseLog("places.csv", BytesOf(text));
  ASSERT_TRUE(log.ok()) << log.error().message;
  ASSERT_EQ(log->events.size(), 2u);
  EXPECT_FALSE(log->events[1].has_time);
  EXPECT_EQ(log->events[1].image_name, "IMG_2.jpg");
  EXPECT_DOUBLE_EQ(log->events[1].position->lat_deg, 46.81);
  EXPECT_DOUBLE_EQ(*log->events[1].height_amsl_m, 561.0);
  EXPECT_EQ(log->warnings.size(), 1u);
}

TEST(ExplainUnknownTable, SaysWhatATableLacks) {
  const auto no_time =
      ExplainUnknownTable(BytesOf("stamp,lat_deg,lon_deg\n1,46.8,7.1\n2,46.8,7.1\n"), "track.csv");
  ASSERT_TRUE(no_time);
  EXPECT_THAT(InWords(*no_time), HasSubstr("track.csv"));
  EXPECT_THAT(InWords(*no_time), HasSubstr("no column of it is recognised as a time"));
  EXPECT_THAT(InWords(*no_time), HasSubstr("recognised are lat_deg, lon_deg"));
  EXPECT_THAT(InWords(*no_time), HasSubstr("not recognised are stamp"));
  const auto no_use = ExplainUnknownTable(BytesOf("time_s,battery\n1,46\n2,46\n"), "power.csv");
  ASSERT_TRUE(no_use);
  EXPECT_THAT(InWords(*no_use), HasSubstr("beside the time"));
  EXPECT_FALSE(ExplainUnknownTable(BytesOf("Dear all,\nplease find, time, attached\n"), "a.csv"));
  EXPECT_FALSE(ExplainUnknownTable(BytesOf("a,b\nonly,words\nhere,too\n"), "a.csv"));
  EXPECT_FALSE(ExplainUnknownTable(BytesOf(""), "a.csv"));
  std::string wide = "c0";
  std::string row = "0";
  for (int i = 1; i < 1000; ++i) {
    wide += "," + std::string(500, 'x');
    row += ",1";
  }
  const auto bounded = ExplainUnknownTable(BytesOf(wide + "\n" + row + "\n" + row + "\n"), "a.csv");
  ASSERT_TRUE(bounded);
  EXPECT_LT(InWords(*bounded).size(), 1000u);
}

}  // namespace
}  // namespace skyquilt::flight
