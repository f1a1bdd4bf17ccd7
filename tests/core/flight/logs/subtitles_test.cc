#include <gmock/gmock.h>

#include "core/flight/bytes/gps_time.h"
#include "core/flight/logs/formats.h"
#include "core/flight/logs/read_log.h"
#include "core/flight/logs/subtitles/cue_text.h"
#include "tests/support/value_of.h"

namespace skyquilt::flight {
namespace {

using test::ErrorOf;
using test::ValueOf;
using ::testing::HasSubstr;

TEST(ReadCue, KnowsTheDialectsOfDjiAndAutel) {
  struct Case {
    const char* text;
    double lat_deg, lon_deg;
    std::optional<double> height_amsl_m, height_above_takeoff_m;
  };
  for (const Case& each : {
           Case{"HOME(-91.9, 46.8) 2016.6.23 16:31:59\nGPS(W: -91.99456, N: 46.842607, 198) ReH:40 ",
                46.842607, -91.99456, 198.0, 40.0},
           Case{"GPS(W: 91.99456, N: 46.842607, 198.5m)", 46.842607, -91.99456, 198.5, {}},
           Case{"GPS(E: 8.5, S: 33.25, 10)", -33.25, 8.5, 10.0, {}},
           Case{"gps (n: 46.842607, w: 91.99456, 198)", 46.842607, -91.99456, 198.0, {}},
           Case{"GPS(46.842607N, 91.99456\xC2\xB0W, 198)", 46.842607, -91.99456, 198.0, {}},
           Case{"HOME(149.0251,-20.2532) 2017.08.05 14:11:51\nGPS(149.0251,-20.2533,16) BAROMETER:1.9",
                -20.2533,
                149.0251,
                {},
                1.9},
           Case{"GPS(36.6146,-6.1120,0.0M) BAROMETER:0.3M", 36.6146, -6.112, {}, 0.3},
           Case{"F/2.8, SS 1250, ISO 100, EV 0, GPS (8.6, 47.3, 15), D 12.3m, H 40.0m, H.S 0.00m/s",
                47.3,
                8.6,
                {},
                40.0},
           Case{"D 40.4ft, H 131.23ft GPS (8.6, 47.3, 15)", 47.3, 8.6, {}, 131.23 * 0.3048},
           Case{"[latitude: 47.3] [longitude: 8.6] [rel_alt: 12.5 abs_alt: 117.25]", 47.3, 8.6, 117.25, 12.5},
           Case{"[latitude: 47,3] [longitude: 8,625] [rel_alt: 12,5 abs_alt: 117,25]", 47.3, 8.625, 117.25,
                12.5},
           Case{"GPS(149,0251,-20,2533,16) BAROMETER:1,9", -20.2533, 149.0251, {}, 1.9},
           Case{"GPS (8,0625, 47,3, 15), D 12, H 40, H.S 0", 47.3, 8.0625, {}, 40.0},
           Case{"GPS(36,6146,-6,1120,0,0M) BAROMETER:0,3M", 36.6146, -6.112, {}, 0.3},
           Case{"<font size=\"28\">[latitude : -47.3] [longtitude : 8.6] [altitude: 300.5]</font>",
                -47.3,
                8.6,
                300.5,
                {}},
       }) {
    const CueFacts facts = ReadCue(each.text);
    ASSERT_TRUE(facts.position) << each.text;
    EXPECT_DOUBLE_EQ(facts.position->lat_deg, each.lat_deg) << each.text;
    EXPECT_DOUBLE_EQ(facts.position->lon_deg, each.lon_deg) << each.text;
    EXPECT_EQ(facts.height_amsl_m, each.height_amsl_m) << each.text;
    ASSERT_EQ(facts.height_above_takeoff_m.has_value(), each.height_above_takeoff_m.has_value()) << each.text;
    if (each.height_above_takeoff_m) {
      EXPECT_NEAR(*facts.height_above_takeoff_m, *each.height_above_takeoff_m, 1e-9) << each.text;
    }
  }
  for (const char* text : {"", "HOME(8.5, 47.3)", "GPS(8.5, 47.3", "GPS()", "GPS(a, b, c)", "GPS 8.5 47.3",
                           "[latitude: 47.3]"}) {
    EXPECT_FALSE(ReadCue(text).position) << text;
  }
}

TEST(CueDate, IsFoundAmidOtherWords) {
  EXPECT_EQ(CueDate("HOME(-91.9, 46.8) 2016.6.23 16:31:59\nGPS")->time,
            *UtcFromCivil(2016, 6, 23, 16, 31, 59.0));
  EXPECT_EQ(CueDate("x\n2016-06-23 16:31:09,123,456\n")->time, *UtcFromCivil(2016, 6, 23, 16, 31, 9.123456));
  EXPECT_FALSE(CueDate("ISO 2000 and 2016.6.23"));
}

std::string AssFile(const std::string& dialogues) {
  return "\xEF\xBB\xBF[Script Info]\r\nScriptType: v4.00+\r\n[V4+ Styles]\r\nFormat: Name, Fontname, Fontsize\r\n"
         "Style: Default,Arial,16\r\n[Events]\r\nFormat: Layer, Start, End, Style, Name, MarginL, MarginR, MarginV, "
         "Effect, Text\r\n" +
         dialogues;
}

TEST(ParseAss, ReadsDialogues) {
  const std::string text = AssFile(
      "Dialogue: 0,0:00:01.50,0:00:02.00,Default,,0,0,0,,{\\an7}2016.6.23 16:32:00\\NGPS(W: -91.5, N: 46.25, 198) "
      "ReH:40\\NISO:100\r\nComment: 0,0:00:01.60,0:00:02.00,Default,,0,0,0,,GPS(W: 1, N: 1, 1)\r\n"
      "Dialogue: 0,0:01:01.50,0:01:02.00,Default,,0,0,0,,2016.6.23 16:33:00\\NGPS(W: -91.25, N: 46.5, 199)\r\n"
      "Dialogue: broken\r\n");
  EXPECT_EQ(ValueOf(ParseLog("MAX_0001.ASS", BytesOf(text))).format, "ass");
  const auto log = ValueOf(ParseAss("MAX_0001.ASS", BytesOf(text)));
  ASSERT_EQ(log.gnss.size(), 2U);
  EXPECT_DOUBLE_EQ(log.gnss[0].t_s, 1.5);
  EXPECT_DOUBLE_EQ(log.gnss[1].t_s, 61.5);
  EXPECT_DOUBLE_EQ(log.gnss[0].position.lat_deg, 46.25);
  EXPECT_DOUBLE_EQ(log.gnss[0].position.lon_deg, -91.5);
  EXPECT_EQ(log.gnss[1].height_amsl_m, 199.0);
  ASSERT_EQ(log.baro.size(), 1U);
  EXPECT_DOUBLE_EQ(log.baro[0].height_above_takeoff_m, 40.0);
  EXPECT_EQ(log.local_at_zero, UtcFromCivil(2016, 6, 23, 16, 31, 58.5));
}

TEST(ParseAss, TakesTheOrderOfFieldsFromTheFormatLine) {
  const std::string text =
      "[Events]\nFormat: Start, Layer, Text\nDialogue: 0:00:02.25,0,GPS(E: 8.5, N: 47.5, 400), more\n";
  EXPECT_DOUBLE_EQ(ValueOf(ParseAss("a.ass", BytesOf(text))).gnss.at(0).t_s, 2.25);
}

TEST(ParseAss, QuotesWhatHoldsNoPosition) {
  const Error none = ErrorOf(
      ParseAss("a.ass", BytesOf(AssFile("Dialogue: 0,0:00:01.50,0:00:02.00,D,,0,0,0,,Hello\\Nthere\n"))));
  EXPECT_EQ(none.code, ErrorCode::kNoPosition);
  EXPECT_THAT(none.message, HasSubstr("\"Hello?there\""));
  EXPECT_EQ(ParseAss("a.ass", BytesOf(AssFile(""))).error().code, ErrorCode::kCorrupt);
}

// Seven seconds of film a cue, while the clock goes on for `clock_step_s`.
std::string Lapse(int clock_step_s) {
  std::string text;
  for (int i = 0; i < 20; ++i) {
    const int clock_s = i * clock_step_s;
    text += std::to_string(i) + "\n00:" + std::to_string(i * 7 / 60) + ":" + std::to_string(i * 7 % 60) +
            ",000 --> 00:59:00,000\nHOME(8.5,47.5) 2016.6.23 16:" + std::to_string(10 + clock_s / 60) + ":" +
            std::to_string(clock_s % 60) + "\nGPS(8.5," + std::to_string(47.0 + 0.001 * i) + ",16)\n\n";
  }
  return text;
}

TEST(ParseDjiSrt, FollowsTheClockWhereTheFilmIsShorter) {
  EXPECT_DOUBLE_EQ(ValueOf(ParseDjiSrt("a.srt", BytesOf(Lapse(7)))).gnss.back().t_s, 133.0);
  const auto lapse = ValueOf(ParseDjiSrt("a.srt", BytesOf(Lapse(30))));
  ASSERT_EQ(lapse.gnss.size(), 20U);
  EXPECT_DOUBLE_EQ(lapse.gnss.back().t_s, 570.0);
  EXPECT_EQ(lapse.local_at_zero, UtcFromCivil(2016, 6, 23, 16, 10, 0.0));
  const auto film = ValueOf(ParseFilmSubtitles("a.srt", BytesOf(Lapse(30))));
  EXPECT_DOUBLE_EQ(film.gnss.back().t_s, 133.0) << "frames of a film are found by its own time";
}

TEST(ParseDjiSrt, PassesOverOneStrayDate) {
  std::string text = Lapse(7);
  const std::size_t at = text.find("16:10:35");
  ASSERT_NE(at, std::string::npos);
  text.replace(at, 8, "17:10:35");
  const auto log = ValueOf(ParseDjiSrt("a.srt", BytesOf(text)));
  EXPECT_GE(log.gnss.size(), 19U);
  EXPECT_DOUBLE_EQ(log.gnss.back().t_s, 133.0);
  EXPECT_EQ(log.local_at_zero, UtcFromCivil(2016, 6, 23, 16, 10, 0.0));
}

TEST(ParseFilmSubtitles, ReadsBothKinds) {
  const std::string ass = "Dialogue: 0,0:00:02.25,0:00:03.00,D,,0,0,0,,GPS(E: 8.5, N: 47.5, 400)\n";
  ASSERT_TRUE(ParseFilmSubtitles("a.ass", BytesOf(ass)).ok());
  ASSERT_TRUE(ParseFilmSubtitles("a.srt", BytesOf(Lapse(7))).ok());
  EXPECT_FALSE(ParseFilmSubtitles("a.srt", {}).ok());
}

}  // namespace
}  // namespace skyquilt::flight
