// Clocks of logs: GPS weeks and leap seconds, civil dates, written time stamps. Pure functions; any thread.
// Source: IERS Bulletin C (leap seconds up to 2017-01-01; none announced since), IS-GPS-200 (weeks from
// 1980-01-06).
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "core/flight/photos/photo.h"

namespace skyquilt::flight {

inline constexpr std::int64_t kGpsEpochUnixUs = 315'964'800'000'000;  // 1980-01-06

// GPS time minus UTC at an instant given on the GPS clock (microseconds since 1980-01-06 00:00:00 GPS).
int LeapSecondsAtGps(std::int64_t gps_us);

// Nothing for weeks outside 1..10000 or a time of week outside 0..604800 s.
std::optional<UtcTime> UtcFromGpsWeek(std::int64_t week, std::int64_t time_of_week_us);

// Nothing for what is no date of 1970..2200.
std::optional<UtcTime> UtcFromCivil(int year, int month, int day, int hour, int minute, double second);

struct WrittenTime {
  UtcTime time;               // as written; moved to UTC when the text names its zone
  bool names_zone = false;    // "Z" or "+02:00" follows
  double resolution_s = 1.0;  // one unit of the last digit written
};

// "2022-05-01T15:01:58.531Z", "2022-05-01 15:01:58,531,716", "2017.8.5 14:11:51", "2005/04/02 00:00:00.000",
// "2022:05:01 15:01:58", "+02:00" at the end.
std::optional<WrittenTime> ParseWrittenTime(std::string_view text);

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
