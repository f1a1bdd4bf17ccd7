#include "core/flight/bytes/written_time.h"

#include <fmt/chrono.h>

#include <array>
#include <cmath>
#include <cstdint>

#include "core/flight/bytes/gps_time.h"
#include "core/flight/bytes/text_fields.h"

namespace skyquilt::flight {
namespace {

using std::chrono::microseconds;
constexpr std::int64_t kMicroPerSecond = 1'000'000;

}  // namespace

std::optional<UtcTime> UtcFromCivil(int year, int month, int day, int hour, int minute, double second) {
  if (year < 1970 || year > 2200 || month < 1 || month > 12 || day < 1 || day > 31) return std::nullopt;
  if (hour < 0 || hour > 24 || minute < 0 || minute > 59 || !(second >= 0.0 && second < 61.0))
    return std::nullopt;
  const auto date = std::chrono::year(year) / std::chrono::month(static_cast<unsigned>(month)) /
                    std::chrono::day(static_cast<unsigned>(day));
  if (!date.ok()) return std::nullopt;
  const auto midnight =
      std::chrono::duration_cast<microseconds>(std::chrono::sys_days(date).time_since_epoch());
  const std::int64_t us =
      midnight.count() + (hour * 3600LL + minute * 60LL) * kMicroPerSecond + std::llround(second * 1e6);
  return UtcTime(microseconds(us));
}

namespace {

// Reads digits at `at`; nothing when there are none or more than nine.
std::optional<int> TakeNumber(std::string_view text, std::size_t& at) {
  const std::size_t start = at;
  int value = 0;
  while (at < text.size() && IsDigit(text[at]) && at - start < 9) value = value * 10 + (text[at++] - '0');
  if (at == start) return std::nullopt;
  return value;
}

bool TakeOneOf(std::string_view text, std::size_t& at, std::string_view allowed) {
  if (at >= text.size() || allowed.find(text[at]) == std::string_view::npos) return false;
  ++at;
  return true;
}

// The digits after the seconds: ".531", ",531", ",531,716" (milliseconds, then microseconds).
double TakeFraction(std::string_view text, std::size_t& at, double& resolution_s) {
  double value = 0.0;
  double unit = 1.0;
  const auto digits = [&](int most) {
    int count = 0;
    while (at < text.size() && IsDigit(text[at])) {
      if (count < most && unit > 1e-9) value += (text[at] - '0') * (unit *= 0.1);
      ++at;
      ++count;
    }
    return count;
  };
  if (!TakeOneOf(text, at, ".,")) return 0.0;
  const int count = digits(9);
  if (count == 3 && at + 1 < text.size() && text[at] == ',' && IsDigit(text[at + 1])) {
    ++at;
    digits(3);
  }
  resolution_s = unit;
  return value;
}

bool IsAsciiLetter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

// One of the three parts of a date.
struct DatePart {
  int value = 0;
  std::size_t digits = 0;  // 0: a month's name
};

// English names and the German and Spanish ones that begin otherwise, by their first three letters.
int MonthOfName(std::string_view name) {
  struct Month {
    std::string_view name;
    int number;
  };
  constexpr std::array kMonths = {Month{"jan", 1}, Month{"feb", 2},  Month{"mar", 3},  Month{"apr", 4},
                                  Month{"may", 5}, Month{"jun", 6},  Month{"jul", 7},  Month{"aug", 8},
                                  Month{"sep", 9}, Month{"oct", 10}, Month{"nov", 11}, Month{"dec", 12},
                                  Month{"mai", 5}, Month{"okt", 10}, Month{"dez", 12}, Month{"ene", 1},
                                  Month{"abr", 4}, Month{"ago", 8},  Month{"dic", 12}};
  for (const Month& month : kMonths) {
    if (StartsWithIgnoringCase(name, month.name)) return month.number;
  }
  return 0;
}

std::optional<DatePart> TakeDatePart(std::string_view text, std::size_t& at, bool names_too) {
  const std::size_t start = at;
  if (const auto number = TakeNumber(text, at)) return DatePart{*number, at - start};
  while (at < text.size() && IsAsciiLetter(text[at])) ++at;
  const int month = names_too ? MonthOfName(text.substr(start, at - start)) : 0;
  if (month == 0) return std::nullopt;
  return DatePart{month, 0};
}

// The places of year, month and day among three parts.
std::array<std::size_t, 3> PlacesOfDate(const std::array<DatePart, 3>& parts, DateOrder order) {
  if (parts[0].digits == 0) return {2, 0, 1};
  if (parts[0].digits >= 3) return {0, 1, 2};
  if (parts[1].digits == 0) return {2, 1, 0};
  if (order == DateOrder::kMonthFirst) return {2, 0, 1};
  return order == DateOrder::kDayFirst ? std::array<std::size_t, 3>{2, 1, 0}
                                       : std::array<std::size_t, 3>{0, 1, 2};
}

std::optional<std::chrono::sys_days> TakeDate(std::string_view text, std::size_t& at, DateOrder order) {
  const bool is_free = order != DateOrder::kYearFirst;
  std::array<DatePart, 3> parts;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (i > 0) {
      const std::size_t before = at;
      while (TakeOneOf(text, at, is_free ? "-./:, " : "-./:") && is_free) {
      }
      if (at == before) return std::nullopt;
    }
    const auto part = TakeDatePart(text, at, is_free);
    if (!part) return std::nullopt;
    constexpr std::size_t kCompact = 8;
    if (i == 0 && is_free && part->digits == kCompact) {
      parts = {DatePart{part->value / 10000, 4}, DatePart{part->value / 100 % 100, 2},
               DatePart{part->value % 100, 2}};
      break;
    }
    parts[i] = *part;
  }
  const auto [year_at, month_at, day_at] = PlacesOfDate(parts, order);
  int year = parts[year_at].value;
  if (is_free && parts[year_at].digits == 2) year += 2000;
  const auto midnight = UtcFromCivil(year, parts[month_at].value, parts[day_at].value, 0, 0, 0.0);
  if (!midnight) return std::nullopt;
  return std::chrono::floor<std::chrono::days>(*midnight);
}

// "PM", "a.m.": 12 for the afternoon, 0 for the morning.
std::optional<int> TakeHalfOfDay(std::string_view text, std::size_t& at) {
  std::size_t ahead = at;
  const bool is_morning = TakeOneOf(text, ahead, "aA");
  if (!is_morning && !TakeOneOf(text, ahead, "pP")) return std::nullopt;
  if (TakeOneOf(text, ahead, ".")) TakeOneOf(text, ahead, " ");
  if (!TakeOneOf(text, ahead, "mM")) return std::nullopt;
  TakeOneOf(text, ahead, ".");
  if (ahead < text.size() && IsAsciiLetter(text[ahead])) return std::nullopt;  // "am" of another word
  at = ahead;
  return is_morning ? 0 : 12;
}

struct TimeOfDay {
  std::chrono::microseconds since_midnight{};
  std::chrono::minutes zone{};
  bool names_zone = false;
  bool counts_gps = false;  // without the leap seconds of UTC
  double resolution_s = 1.0;
};

constexpr std::string_view kGpsScale = "gpst";

bool TakeZone(std::string_view text, std::size_t& at, TimeOfDay& time) {
  if (TakeOneOf(text, at, "Zz")) {
    time.names_zone = true;
    return true;
  }
  const std::size_t behind = at + kGpsScale.size();
  if (StartsWithIgnoringCase(text.substr(at), kGpsScale) &&
      (behind == text.size() || !IsAsciiLetter(text[behind]))) {
    at = behind;
    time.names_zone = time.counts_gps = true;
    return true;
  }
  if (StartsWithIgnoringCase(text.substr(at), "utc") || StartsWithIgnoringCase(text.substr(at), "gmt")) {
    time.names_zone = true;
    at += 3;
    const std::size_t sign = text.find_first_not_of(' ', at);  // "UTC +02:00"
    const bool has_offset =
        sign != std::string_view::npos && sign + 1 < text.size() && IsDigit(text[sign + 1]);
    if (has_offset && (text[sign] == '+' || text[sign] == '-')) at = sign;
  }
  if (at >= text.size() || (text[at] != '+' && text[at] != '-')) return true;
  const int sign = text[at++] == '+' ? 1 : -1;
  const auto zone = TakeNumber(text, at);
  if (!zone || *zone > 1500) return false;
  const bool is_joined = *zone > 24;  // "+0200"
  const int hours = is_joined ? *zone / 100 : *zone;
  int minutes = is_joined ? *zone % 100 : 0;
  if (!is_joined && TakeOneOf(text, at, ":")) minutes = TakeNumber(text, at).value_or(0);
  if (minutes > 59 || hours * 60 + minutes > 15 * 60) return false;
  time.zone = std::chrono::minutes(sign * (hours * 60 + minutes));
  time.names_zone = true;
  return true;
}

// `is_free`: also "163109".
std::optional<TimeOfDay> TakeTimeOfDay(std::string_view text, std::size_t& at, bool is_free) {
  const std::size_t start = at;
  const auto first = TakeNumber(text, at);
  if (!first) return std::nullopt;
  constexpr std::size_t kCompact = 6;
  std::array<int, 3> hms{*first, 0, 0};
  if (is_free && at - start == kCompact) {
    hms = {*first / 10000, *first / 100 % 100, *first % 100};
  } else {
    for (std::size_t i = 1; i < hms.size(); ++i) {
      if (!TakeOneOf(text, at, ":")) return std::nullopt;
      const auto number = TakeNumber(text, at);
      if (!number) return std::nullopt;
      hms[i] = *number;
    }
  }
  TimeOfDay time;
  const double fraction_s = TakeFraction(text, at, time.resolution_s);
  while (TakeOneOf(text, at, " ")) {
  }
  if (const auto half = TakeHalfOfDay(text, at)) {
    if (hms[0] < 1 || hms[0] > 12) return std::nullopt;
    hms[0] = hms[0] % 12 + *half;
    while (TakeOneOf(text, at, " ")) {
    }
  }
  if (hms[0] > 24 || hms[1] > 59 || hms[2] > 60) return std::nullopt;
  time.since_midnight = microseconds((hms[0] * 3600LL + hms[1] * 60LL) * kMicroPerSecond +
                                     std::llround((hms[2] + fraction_s) * 1e6));
  if (!TakeZone(text, at, time)) return std::nullopt;
  return time;
}

WrittenTime Together(std::chrono::sys_days date, const TimeOfDay& time) {
  WrittenTime written;
  written.time = UtcTime(std::chrono::duration_cast<microseconds>(date.time_since_epoch())) +
                 time.since_midnight - time.zone;
  if (time.counts_gps) written.time = UtcFromGpsCalendar(written.time);
  written.names_zone = time.names_zone;
  written.resolution_s = time.resolution_s;
  return written;
}

}  // namespace

std::optional<WrittenTime> ParseWrittenTime(std::string_view text, DateOrder order) {
  text = Trim(text);
  std::size_t at = 0;
  const bool is_free = order != DateOrder::kYearFirst;
  const auto date = TakeDate(text, at, order);
  if (!date || !TakeOneOf(text, at, is_free ? "T ," : "T ")) return std::nullopt;
  while (TakeOneOf(text, at, " ")) {
  }
  const auto time = TakeTimeOfDay(text, at, is_free);
  if (!time) return std::nullopt;
  return Together(*date, *time);
}

std::optional<WrittenTime> ParseWrittenTime(std::string_view date, std::string_view time_of_day,
                                            DateOrder order) {
  const auto day = ParseDate(date, order);
  std::size_t at = 0;
  const auto time = TakeTimeOfDay(Trim(time_of_day), at, true);
  if (!day || !time) return std::nullopt;
  return Together(*day, *time);
}

std::optional<std::chrono::sys_days> ParseDate(std::string_view text, DateOrder order) {
  std::size_t at = 0;
  text = Trim(text);
  const auto date = TakeDate(text, at, order);
  return date;
}

bool IsTimeOfDay(std::string_view text) {
  std::size_t at = 0;
  return TakeTimeOfDay(Trim(text), at, true).has_value();
}

std::string WrittenSecond(UtcTime time) {
  const auto seconds = std::chrono::floor<std::chrono::seconds>(time);
  return fmt::format("{:%Y-%m-%dT%H:%M:%S}", fmt::gmtime(std::chrono::system_clock::to_time_t(seconds)));
}

std::optional<double> ParseElapsed(std::string_view text) {
  text = Trim(text);
  std::size_t at = 0;
  if (const auto time = TakeTimeOfDay(text, at, false); time && at == text.size())
    return std::chrono::duration<double>(time->since_midnight).count();
  at = 0;
  double total_s = 0.0, resolution_s = 1.0;
  bool has_unit = false;
  while (at < text.size()) {
    const auto whole = TakeNumber(text, at);
    if (!whole) return std::nullopt;
    if (!has_unit && total_s == 0.0 && TakeOneOf(text, at, ":")) {  // "12:05.5"
      const auto second = TakeNumber(text, at);
      if (!second || *second > 59) return std::nullopt;
      total_s = *whole * 60.0 + *second + TakeFraction(text, at, resolution_s);
      return at == text.size() ? std::optional(total_s) : std::nullopt;
    }
    const double number = *whole + TakeFraction(text, at, resolution_s);
    if (TakeOneOf(text, at, "hH"))
      total_s += 3600.0 * number;
    else if (TakeOneOf(text, at, "mM"))
      total_s += 60.0 * number;
    else if (TakeOneOf(text, at, "sS"))
      total_s += number;
    else
      return std::nullopt;
    has_unit = true;
    while (TakeOneOf(text, at, " ")) {
    }
  }
  return has_unit ? std::optional(total_s) : std::nullopt;
}

}  // namespace skyquilt::flight
