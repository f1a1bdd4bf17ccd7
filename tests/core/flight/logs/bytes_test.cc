// Clocks, times as they are written, and texts in UTF-16.
#include <gtest/gtest.h>

#include <string>

#include "core/flight/bytes/gps_time.h"
#include "core/flight/bytes/text_fields.h"
#include "core/flight/logs/explain_unknown.h"
#include "core/flight/logs/formats.h"
#include "core/flight/logs/read_log.h"
#include "core/flight/logs/texts/gcp_list.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/value_of.h"

namespace skyquilt::flight {
namespace {

TEST(UtcFromGpsWeek, AppliesTheLeapSecondsOfItsDay) {
  // The GPS epoch's first weeks had none; 2005 had 13, 2016 had 17, today has 18.
  EXPECT_EQ(*UtcFromGpsWeek(1, 0), *UtcFromCivil(1980, 1, 13, 0, 0, 0.0));
  EXPECT_EQ(*UtcFromGpsWeek(1316, 518'400'000'000), *UtcFromCivil(2005, 4, 1, 23, 59, 47.0));
  EXPECT_EQ(*UtcFromGpsWeek(1905, 0), *UtcFromCivil(2016, 7, 9, 23, 59, 43.0));
  EXPECT_EQ(*UtcFromGpsWeek(2211, 296'288'242'869), *UtcFromCivil(2022, 5, 25, 10, 17, 50.242869));
}

TEST(UtcFromGpsWeek, StepsAtTheLeapSecondItself) {
  // 2017-01-01 00:00:00 UTC is 18 s into that GPS day, which began in week 1930.
  const auto before = UtcFromGpsWeek(1930, 16'500'000);
  EXPECT_EQ(*UtcFromGpsWeek(1930, 18'000'000), *UtcFromCivil(2017, 1, 1, 0, 0, 0.0));
  EXPECT_EQ(*before, *UtcFromCivil(2016, 12, 31, 23, 59, 59.5));
}

TEST(UtcFromGpsWeek, RefusesWhatIsNoWeek) {
  EXPECT_FALSE(UtcFromGpsWeek(0, 0).has_value());
  EXPECT_FALSE(UtcFromGpsWeek(2211, 604'800'000'001).has_value());
  EXPECT_FALSE(UtcFromGpsWeek(2211, -1).has_value());
}

TEST(ParseWrittenTime, ReadsEveryWayLogsWriteIt) {
  const UtcTime expected = *UtcFromCivil(2022, 5, 1, 15, 1, 58.0);
  for (const char* text :
       {"2022-05-01T15:01:58Z", "2022-05-01 15:01:58", "2022.5.1 15:01:58", "2022:05:01 15:01:58",
        "2022/05/01 15:01:58.000", "2022-05-01T17:01:58+02:00", "2022-05-01T17:01:58+0200",
        "2022-05-01T09:31:58-05:30", "2022-05-01T09:31:58-0530", "2022-05-02T06:01:58+15"}) {
    const auto time = ParseWrittenTime(text);
    ASSERT_TRUE(time.has_value()) << text;
    EXPECT_EQ(time->time, expected) << text;
  }
  EXPECT_EQ(ParseWrittenTime("2022-05-01 15:01:58,531,716")->time,
            *UtcFromCivil(2022, 5, 1, 15, 1, 58.531716));
  EXPECT_NEAR(ParseWrittenTime("2022-05-01 15:01:58.25")->resolution_s, 0.01, 1e-9);
  EXPECT_TRUE(ParseWrittenTime("2022-05-01T15:01:58Z")->names_zone);
  EXPECT_FALSE(ParseWrittenTime("2022-05-01T15:01:58")->names_zone);
}

TEST(ParseWrittenTime, RefusesWhatIsNoDate) {
  for (const char* text : {"", "2022", "2022-13-01 00:00:00", "2022-02-30 00:00:00", "2022-05-01 25:00:00",
                           "99999999999-01-01 00:00:00", "2022-05-01 15:01", "0000:00:00 00:00:00"}) {
    EXPECT_FALSE(ParseWrittenTime(text).has_value()) << text;
  }
}

TEST(ParseWrittenTime, ReadsDatesOfTablesInTheirOrder) {
  struct Case {
    DateOrder order;
    const char* text;
  };
  for (const Case& c :
       {Case{DateOrder::kMonthFirst, "6/3/2016 09:31:09 PM"},
        Case{DateOrder::kMonthFirst, "6/3/2016, 9:31:09 p.m."},
        Case{DateOrder::kDayFirst, "3/6/2016 21:31:09"}, Case{DateOrder::kDayFirst, "03.06.16 21:31:09"},
        Case{DateOrder::kDayFirst, "3-6-2016 21:31:09"}, Case{DateOrder::kDayFirst, "3 Jun 2016 21:31:09"},
        Case{DateOrder::kDayFirst, "Jun 3, 2016 9:31:09 PM"}, Case{DateOrder::kDayFirst, "20160603T213109Z"},
        Case{DateOrder::kDayFirst, "2016-06-03 21:31:09 UTC"},
        Case{DateOrder::kDayFirst, "2016-06-03 23:31:09 UTC +02:00"},
        Case{DateOrder::kDayFirst, "2016-06-03 14:31:09 GMT -0700"},
        Case{DateOrder::kShortYearFirst, "16-06-03 21:31:09"},
        Case{DateOrder::kMonthFirst, "2016-06-03T23:31:09+02:00"}}) {
    const auto time = ParseWrittenTime(c.text, c.order);
    ASSERT_TRUE(time.has_value()) << c.text;
    EXPECT_EQ(time->time, *UtcFromCivil(2016, 6, 3, 21, 31, 9.0)) << c.text;
  }
  EXPECT_EQ(ParseWrittenTime("6/23/2016", "4:31:19.50 PM", DateOrder::kMonthFirst)->time,
            *UtcFromCivil(2016, 6, 23, 16, 31, 19.5));
  EXPECT_EQ(ParseWrittenTime("23.06.2016", "12:00:00 AM", DateOrder::kDayFirst)->time,
            *UtcFromCivil(2016, 6, 23, 0, 0, 0.0));
}

TEST(ParseWrittenTime, TakesTheLeapSecondsOffGpsTime) {
  const auto gps = test::ValueOf(ParseWrittenTime("2024-05-01 10:00:00.5 GPST"));
  EXPECT_EQ(gps.time, *UtcFromCivil(2024, 5, 1, 9, 59, 42.5));
  EXPECT_TRUE(gps.names_zone);
  EXPECT_EQ(ParseWrittenTime("1.1.2017", "00:00:10 gpst", DateOrder::kDayFirst)->time,
            *UtcFromCivil(2016, 12, 31, 23, 59, 53.0));
  EXPECT_FALSE(test::ValueOf(ParseWrittenTime("2024-05-01 10:00:00 GPSTimestamp")).names_zone);
}

TEST(ParseWrittenTime, RefusesDatesInAnotherOrder) {
  EXPECT_FALSE(ParseWrittenTime("6/23/2016 21:31:09"));
  EXPECT_FALSE(ParseWrittenTime("6/23/2016 21:31:09", DateOrder::kDayFirst));
  EXPECT_FALSE(ParseWrittenTime("23/6/2016 21:31:09", DateOrder::kMonthFirst));
  EXPECT_FALSE(ParseWrittenTime("6/3/2016 13:31:09 PM", DateOrder::kMonthFirst));
  EXPECT_FALSE(ParseWrittenTime("3 Foo 2016 21:31:09", DateOrder::kDayFirst));
  EXPECT_FALSE(ParseWrittenTime("6/3/2016", "25:00:00", DateOrder::kMonthFirst));
  EXPECT_FALSE(ParseDate("46.8426", DateOrder::kDayFirst));
}

TEST(ParseElapsed, ReadsClocksThatCountFromTheStart) {
  EXPECT_DOUBLE_EQ(*ParseElapsed("0m 12.5s"), 12.5);
  EXPECT_DOUBLE_EQ(*ParseElapsed("1h 2m 3s"), 3723.0);
  EXPECT_DOUBLE_EQ(*ParseElapsed("0:12:05.5"), 725.5);
  EXPECT_DOUBLE_EQ(*ParseElapsed("12:05"), 725.0);
  for (const char* text : {"", "12.5", "12 apples", "1:2:3:4", "m", "0:75"})
    EXPECT_FALSE(ParseElapsed(text)) << text;
}

TEST(ParseWrittenTime, RefusesZonesThatAreNone) {
  for (const char* zone :
       {"+", "+16", "+15:01", "+1501", "+02:75", "+0275", "-951022222:00", "+999999999", "+00:999999999"}) {
    EXPECT_FALSE(ParseWrittenTime(std::string("2022-05-01T15:01:58") + zone).has_value()) << zone;
  }
}

TEST(ClockPairs, IsNotMovedByAFewWrongPairs) {
  ClockPairs pairs;
  const UtcTime zero = *UtcFromCivil(2020, 1, 1, 0, 0, 0.0);
  for (int i = 0; i < 20'000; ++i) {
    const auto wrong = i % 10 == 0 ? std::chrono::hours(5) : std::chrono::hours(0);
    pairs.Add(i * 0.2, zero + std::chrono::milliseconds(i * 200) + wrong);
  }
  const auto fit = test::ValueOf(pairs.Solve());
  EXPECT_EQ(fit.utc_at_zero, zero);
  EXPECT_LT(fit.scatter_s, 1e-6);
}

// Letters of the first plane only.
std::string Utf16(std::u16string_view text, bool is_big_endian, bool has_mark) {
  std::string bytes;
  const auto put = [&](char16_t unit) {
    const char low = static_cast<char>(unit & 0xFF), high = static_cast<char>(unit >> 8);
    bytes += is_big_endian ? high : low;
    bytes += is_big_endian ? low : high;
  };
  if (has_mark) put(0xFEFF);
  for (const char16_t unit : text) put(unit);
  return bytes;
}

TEST(LogText, DecodesBothOrdersWithAndWithoutMark) {
  for (const bool is_big_endian : {false, true}) {
    for (const bool has_mark : {false, true}) {
      const std::string bytes = Utf16(u"image;latitude;longitude\r\n", is_big_endian, has_mark);
      const auto text = test::ValueOf(LogText::Of("a.csv", BytesOf(bytes)));
      EXPECT_TRUE(text.is_decoded());
      EXPECT_EQ(TextOf(text.bytes()), "image;latitude;longitude\r\n");
    }
  }
  const std::string signs = Utf16(u"46\u00B050\u2032 \U0001F681 \xD800 end", false, true);
  EXPECT_EQ(TextOf(LogText::Of("a", BytesOf(signs))->bytes()),
            "46\xC2\xB0"
            "50\xE2\x80\xB2 \xF0\x9F\x9A\x81 \xEF\xBF\xBD end");
}

TEST(LogText, LeavesOtherBytesAsTheyAre) {
  for (const std::string& bytes :
       {std::string("image,lat\n"), std::string("\xFF\xFE\0\0a\0\0\0", 8),
        std::string("\xFF\xD8\xFF\xE0 jpeg"), std::string("a\0b\0", 4), std::string()}) {
    const auto text = test::ValueOf(LogText::Of("a", BytesOf(bytes)));
    EXPECT_FALSE(text.is_decoded());
    EXPECT_EQ(TextOf(text.bytes()), bytes);
  }
  const std::string marked = "\xEF\xBB\xBFimage";
  EXPECT_EQ(TextOf(LogText::Of("a", BytesOf(marked))->bytes()), "image");
}

TEST(LogText, RefusesWhatWouldNotFit) {
  std::string bytes((std::size_t{64} << 20) + 2, '\0');
  bytes[0] = '\xFF';
  bytes[1] = '\xFE';
  bytes[2] = 'a';
  const Error text = test::ErrorOf(LogText::Of("big.csv", BytesOf(bytes)));
  EXPECT_NE(text.message.find("big.csv"), std::string::npos);
  EXPECT_NE(text.message.find("save it as UTF-8"), std::string::npos);
}

TEST(ReadLog, ReadsAnySortOfTextInUtf16) {
  const auto table =
      Utf16(u"time_s\tlat\tlon\talt_m\n1\t46.8\t7.1\t500\n2\t46.8001\t7.1\t500\n", false, true);
  EXPECT_EQ(**RecogniseLog(BytesOf(table), "a.csv"), LogKind::kFlight);
  EXPECT_EQ(ParseLog("a.csv", BytesOf(table))->gnss.size(), 2u);
  const auto gpx = Utf16(
      u"<?xml version=\"1.0\"?><gpx><trk><trkseg><trkpt lat=\"46.8\" lon=\"7.1\"><ele>1</ele>"
      u"<time>2016-06-23T21:31:09Z</time></trkpt></trkseg></trk></gpx>",
      true, true);
  EXPECT_EQ(ParseLog("a.gpx", BytesOf(gpx))->gnss.size(), 1u);
  const auto unknown = Utf16(u"stamp,lat_deg,lon_deg\n1,46.8,7.1\n2,46.8,7.1\n", false, true);
  EXPECT_TRUE(ExplainUnknownTable(LogText::Of("a.csv", BytesOf(unknown))->bytes(), "a.csv"));
  const auto subtitles = Utf16(u"1\n00:00:01,000 --> 00:00:02,000\nGPS(7.1,46.8,15)\n\n", false, true);
  EXPECT_EQ(ParseFilmSubtitles("a.srt", BytesOf(subtitles))->gnss.size(), 1u);
}

TEST(ReadGcpList, ReadsUtf16) {
  const test::TemporaryFolder folder;
  const auto path = folder.Write(
      "gcp_list.txt", Utf16(u"EPSG:32615\n576667.1 5188164.6 198.3 100 200 a.jpg gcp1\n", false, true));
  for (const auto& list : {ReadGcpList({"gcp_list.txt", path}), ReadWrittenGcpList({"gcp_list.txt", path})}) {
    ASSERT_TRUE(list.ok()) << list.error().message;
    EXPECT_EQ(list->sightings.size(), 1u);
  }
}

}  // namespace
}  // namespace skyquilt::flight
