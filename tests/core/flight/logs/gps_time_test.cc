#include "core/flight/bytes/gps_time.h"

#include <gtest/gtest.h>

#include <string>

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
  const auto after = UtcFromGpsWeek(1930, 18'000'000);
  EXPECT_EQ(*after, *UtcFromCivil(2017, 1, 1, 0, 0, 0.0));
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
  const auto fit = pairs.Solve();
  ASSERT_TRUE(fit.has_value());
  EXPECT_EQ(fit->utc_at_zero, zero);
  EXPECT_LT(fit->scatter_s, 1e-6);
}

}  // namespace
}  // namespace skyquilt::flight
