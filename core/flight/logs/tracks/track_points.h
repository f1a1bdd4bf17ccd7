// TrackPoints: gathers the points of a track file, in any order and each with what of it could be read, into
// a FlightLog: GNSS samples in the order of time, t_s = 0 at the first. Heights above mean sea level, above
// the ellipsoid or above the place of take-off, metres. At most 2 million points. One thread; used once.
// Fails with kNoPosition, saying what the points lack: a time, one that can be read, a place on Earth.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/flight/bytes/gps_time.h"
#include "core/flight/logs/flight_log.h"

namespace skyquilt::flight {

inline constexpr std::size_t kMaxTrackPoints = 2'000'000;

// "2016-06-23T21:31:09Z" and its likes, or seconds, milli- or microseconds since 1970.
std::optional<WrittenTime> TrackTime(std::string_view text);

struct TrackPoint {
  double lat_deg = 0.0;
  double lon_deg = 0.0;
  std::optional<double> height_amsl_m;
  std::optional<double> height_ellipsoid_m;
  std::optional<double> height_above_takeoff_m;
};

class TrackPoints {
 public:
  // What a time without a zone is: UTC, or the recorder's own clock.
  enum class BareTime { kUtc, kLocal };

  TrackPoints(std::string_view format, std::string_view file_name, BareTime bare_time);

  // No point: its position cannot be read. `written_time` is empty where the point has none.
  void Add(const std::optional<TrackPoint>& point, std::string_view written_time);
  std::uint64_t count() const { return points_; }
  // `mapping`: what heights were taken for, in words.
  Result<FlightLog> Finish(std::vector<std::string> mapping) &&;

 private:
  struct Placed {
    UtcTime time;
    TrackPoint point;
  };
  Error WhyNone() const;

  std::string format_;
  std::string file_name_;
  BareTime bare_time_;
  std::vector<Placed> placed_;
  std::uint64_t points_ = 0;
  std::uint64_t without_place_ = 0;
  std::uint64_t without_time_ = 0;
  std::uint64_t unread_times_ = 0;
  std::uint64_t without_zone_ = 0;
  std::string first_unread_time_;
};

}  // namespace skyquilt::flight
