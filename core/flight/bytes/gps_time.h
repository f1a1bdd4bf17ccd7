// Clocks of logs: GPS weeks and leap seconds, and the offset between two clocks. Pure functions; any thread.
// Source: IERS Bulletin C (leap seconds up to 2017-01-01; none announced since), IS-GPS-200 (weeks from
// 1980-01-06).
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/flight/bytes/written_time.h"

namespace skyquilt::flight {

inline constexpr std::int64_t kGpsEpochUnixUs = 315'964'800'000'000;  // 1980-01-06
inline constexpr std::int64_t kGpsWeekUs = 604'800'000'000;

// Old receivers count their weeks anew after 1,024: their dates are off by multiples of this.
inline constexpr double kGpsWeeksRunOverS = 1024.0 * 7.0 * 86'400.0;

// GPS time minus UTC at an instant given on the GPS clock (microseconds since 1980-01-06 00:00:00 GPS).
int LeapSecondsAtGps(std::int64_t gps_us);

// Of a date and time of day that count GPS time: a calendar without leap seconds.
UtcTime UtcFromGpsCalendar(UtcTime as_written);

// Nothing for weeks outside 1..10000 or a time of week outside 0..604800 s.
std::optional<UtcTime> UtcFromGpsWeek(std::int64_t week, std::int64_t time_of_week_us);

// Pairs of (the log's clock, UTC) gathered while reading, and the offset between them. Keeps at most 4096
// pairs, evenly thinned.
class ClockPairs {
 public:
  void Add(double t_s, UtcTime utc);
  struct Fit {
    UtcTime utc_at_zero;
    double scatter_s = 0.0;  // robust 1-sigma of one pair
  };
  // The median offset; nothing without pairs.
  std::optional<Fit> Solve() const;

 private:
  struct Pair {
    double t_s;
    std::int64_t utc_us;
  };
  std::vector<Pair> pairs_;
  std::uint64_t seen_ = 0;
  std::uint64_t stride_ = 1;
};

}  // namespace skyquilt::flight
