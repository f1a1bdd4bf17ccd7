#include "core/flight/logs/gps_time.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/median.h"
#include "core/flight/logs/text_fields.h"

namespace skyquilt::flight {
namespace {

using std::chrono::microseconds;
constexpr std::int64_t kMicro = 1'000'000;
constexpr std::int64_t kWeekUs = 604'800 * kMicro;

// Days since 1970-01-01 of the first UTC day after each leap second.
constexpr std::chrono::sys_days Day(int y, unsigned m) {
  return std::chrono::sys_days(std::chrono::year(y) / std::chrono::month(m) / std::chrono::day(1));
}
constexpr std::array kLeapDays = {Day(1981, 7), Day(1982, 7), Day(1983, 7), Day(1985, 7), Day(1988, 1),
                                  Day(1990, 1), Day(1991, 1), Day(1992, 7), Day(1993, 7), Day(1994, 7),
                                  Day(1996, 1), Day(1997, 7), Day(1999, 1), Day(2006, 1), Day(2009, 1),
                                  Day(2012, 7), Day(2015, 7), Day(2017, 1)};

}  // namespace

int LeapSecondsAtGps(std::int64_t gps_us) {
  int leap = 0;
  for (const auto& day : kLeapDays) {
    const std::int64_t utc_us = std::chrono::duration_cast<microseconds>(day.time_since_epoch()).count();
    if (gps_us < utc_us - kGpsEpochUnixUs + (leap + 1) * kMicro) break;
    ++leap;
  }
  return leap;
}

std::optional<UtcTime> UtcFromGpsWeek(std::int64_t week, std::int64_t time_of_week_us) {
  if (week < 1 || week > 10'000 || time_of_week_us < 0 || time_of_week_us > kWeekUs) return std::nullopt;
  const std::int64_t gps_us = week * kWeekUs + time_of_week_us;
  return UtcTime(microseconds(kGpsEpochUnixUs + gps_us - LeapSecondsAtGps(gps_us) * kMicro));
}

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
      midnight.count() + (hour * 3600LL + minute * 60LL) * kMicro + std::llround(second * 1e6);
  return UtcTime(microseconds(us));
}

namespace {

// Reads digits at `at`; nothing when there are none or more than nine.
std::optional<int> TakeNumber(std::string_view text, std::size_t& at) {
  const std::size_t start = at;
  int value = 0;
  while (at < text.size() && text[at] >= '0' && text[at] <= '9' && at - start < 9)
    value = value * 10 + (text[at++] - '0');
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
    while (at < text.size() && text[at] >= '0' && text[at] <= '9') {
      if (count < most && unit > 1e-9) value += (text[at] - '0') * (unit *= 0.1);
      ++at;
      ++count;
    }
    return count;
  };
  if (!TakeOneOf(text, at, ".,")) return 0.0;
  const int count = digits(9);
  if (count == 3 && at + 1 < text.size() && text[at] == ',' && text[at + 1] >= '0' && text[at + 1] <= '9') {
    ++at;
    digits(3);
  }
  resolution_s = unit;
  return value;
}

}  // namespace

std::optional<WrittenTime> ParseWrittenTime(std::string_view text) {
  text = Trim(text);
  std::size_t at = 0;
  const auto year = TakeNumber(text, at);
  if (!year || !TakeOneOf(text, at, "-./:")) return std::nullopt;
  const auto month = TakeNumber(text, at);
  if (!month || !TakeOneOf(text, at, "-./:")) return std::nullopt;
  const auto day = TakeNumber(text, at);
  if (!day || !TakeOneOf(text, at, "T ")) return std::nullopt;
  while (TakeOneOf(text, at, " ")) {
  }
  const auto hour = TakeNumber(text, at);
  if (!hour || !TakeOneOf(text, at, ":")) return std::nullopt;
  const auto minute = TakeNumber(text, at);
  if (!minute || !TakeOneOf(text, at, ":")) return std::nullopt;
  const auto second = TakeNumber(text, at);
  if (!second || *second > 60) return std::nullopt;
  WrittenTime written;
  const double fraction = TakeFraction(text, at, written.resolution_s);
  const auto time = UtcFromCivil(*year, *month, *day, *hour, *minute, *second + fraction);
  if (!time) return std::nullopt;
  written.time = *time;
  while (TakeOneOf(text, at, " ")) {
  }
  if (TakeOneOf(text, at, "Zz")) {
    written.names_zone = true;
  } else if (at < text.size() && (text[at] == '+' || text[at] == '-')) {
    const int sign = text[at++] == '+' ? 1 : -1;
    const auto zone = TakeNumber(text, at);
    if (!zone || *zone > 1500) return std::nullopt;
    const bool is_joined = *zone > 24;  // "+0200"
    const int hours = is_joined ? *zone / 100 : *zone;
    int minutes = is_joined ? *zone % 100 : 0;
    if (!is_joined && TakeOneOf(text, at, ":")) minutes = TakeNumber(text, at).value_or(0);
    if (minutes > 59 || hours * 60 + minutes > 15 * 60) return std::nullopt;
    minutes += hours * 60;
    written.time -= std::chrono::minutes(sign * minutes);
    written.names_zone = true;
  }
  return written;
}

void ClockPairs::Add(double t_s, UtcTime utc) {
  constexpr std::size_t kMaxPairs = 4096;
  if (seen_++ % stride_ != 0 || !std::isfinite(t_s)) return;
  if (pairs_.size() == kMaxPairs) {
    for (std::size_t i = 0; i < kMaxPairs / 2; ++i) pairs_[i] = pairs_[2 * i];
    pairs_.resize(kMaxPairs / 2);
    stride_ *= 2;
  }
  pairs_.push_back({t_s, utc.time_since_epoch().count()});
}

std::optional<ClockPairs::Fit> ClockPairs::Solve() const {
  if (pairs_.empty()) return std::nullopt;
  // Offsets are taken against the first pair, so that doubles keep their microseconds.
  const Pair& first = pairs_.front();
  std::vector<double> offsets;
  offsets.reserve(pairs_.size());
  for (const Pair& pair : pairs_) {
    offsets.push_back(static_cast<double>(pair.utc_us - first.utc_us) * 1e-6 - (pair.t_s - first.t_s));
  }
  const double offset_s = Median(offsets);
  for (double& offset : offsets) offset = std::abs(offset - offset_s);
  Fit fit;
  fit.scatter_s = 1.4826 * Median(offsets);
  const double zero_us = (offset_s - first.t_s) * 1e6;
  if (!(std::abs(zero_us) < 4e18)) return std::nullopt;
  fit.utc_at_zero = UtcTime(microseconds(first.utc_us + std::llround(zero_us)));
  return fit;
}

}  // namespace skyquilt::flight
