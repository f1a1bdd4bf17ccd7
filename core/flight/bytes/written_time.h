// Dates and times of day as logs and tables write them. Pure functions; any thread. Nothing for what is none.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>

#include "core/flight/photo.h"

namespace skyquilt::flight {

// Nothing for what is no date of 1970..2200.
std::optional<UtcTime> UtcFromCivil(int year, int month, int day, int hour, int minute, double second);

struct WrittenTime {
  UtcTime time;               // as written; moved to UTC when the text names its zone
  bool names_zone = false;    // "Z", "+02:00" or "GPST" follows
  double resolution_s = 1.0;  // one unit of the last digit written
};

// In which order a date of numbers is written. A year of four digits in front is the year in any order.
enum class DateOrder { kYearFirst, kDayFirst, kMonthFirst, kShortYearFirst };

// "2022-05-01T15:01:58.531Z", "2022-05-01 15:01:58,531,716", "2017.8.5 14:11:51", "2005/04/02 00:00:00.000",
// "2022:05:01 15:01:58", "+02:00", "UTC", "GPST" or "PM" at the end. In other orders than kYearFirst also
// "1/5/2022, 3:01:58 PM", "1.5.22 15:01:58", "1 May 2022 15:01:58", "20220501T150158".
std::optional<WrittenTime> ParseWrittenTime(std::string_view text, DateOrder order = DateOrder::kYearFirst);
// The same with the date and the time of day in two texts.
std::optional<WrittenTime> ParseWrittenTime(std::string_view date, std::string_view time_of_day,
                                            DateOrder order);
// A date, whatever follows it.
std::optional<std::chrono::sys_days> ParseDate(std::string_view text, DateOrder order);
// "16:31:09.5", "4:31:09 PM", "163109"; also with a zone.
bool IsTimeOfDay(std::string_view text);
// "2022-05-01T15:01:58": cut to the second, without a zone.
std::string WrittenSecond(UtcTime time);
// Seconds of "0:12:05.5", "12:05", "12m 5.5s", "1h 2m 3s", or of a time of day.
std::optional<double> ParseElapsed(std::string_view text);

}  // namespace skyquilt::flight
