#include "core/flight/bytes/gps_time.h"

#include <array>
#include <cmath>

#include "core/base/median.h"

namespace skyquilt::flight {
namespace {

using std::chrono::microseconds;
constexpr std::int64_t kMicro = 1'000'000;

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

UtcTime UtcFromGpsCalendar(UtcTime as_written) {
  const std::int64_t gps_us = as_written.time_since_epoch().count() - kGpsEpochUnixUs;
  return as_written - std::chrono::seconds(LeapSecondsAtGps(gps_us));
}

std::optional<UtcTime> UtcFromGpsWeek(std::int64_t week, std::int64_t time_of_week_us) {
  if (week < 1 || week > 10'000 || time_of_week_us < 0 || time_of_week_us > kGpsWeekUs) return std::nullopt;
  const std::int64_t gps_us = week * kGpsWeekUs + time_of_week_us;
  return UtcTime(microseconds(kGpsEpochUnixUs + gps_us - LeapSecondsAtGps(gps_us) * kMicro));
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
  fit.scatter_s = kSigmaOfMedian * Median(offsets);
  const double zero_us = (offset_s - first.t_s) * 1e6;
  if (!(std::abs(zero_us) < 4e18)) return std::nullopt;
  fit.utc_at_zero = UtcTime(microseconds(first.utc_us + std::llround(zero_us)));
  return fit;
}

}  // namespace skyquilt::flight
