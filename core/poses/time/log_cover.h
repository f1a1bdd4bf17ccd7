// LogCover: when a log covers, its holes excluded, and where its track was. A value; any thread.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/flight/logs/flight_log.h"
#include "core/geo/local_frame.h"
#include "core/poses/log_span.h"

namespace skyquilt::poses {

// A receiver that stands wanders by some metres; photos of a map lie further apart than that.
inline constexpr double kStandsWithinM = 10.0;
// A log may begin with its first photo and end with its last, on clocks of whole seconds.
inline constexpr double kCoversBeyondS = 5.0;

class LogCover {
 public:
  explicit LogCover(const flight::FlightLog& log);

  const std::vector<LogSpan>& stretches() const { return stretches_; }  // rising, none meets another
  bool IsEmpty() const { return stretches_.empty(); }
  bool HasTrack() const { return !positions_m_.empty(); }
  bool Covers(double t_s, double beyond_s = kCoversBeyondS) const;
  // Metres east and north of the log's first position; nothing where the log does not cover the time.
  std::optional<Eigen::Vector2d> PositionAt(double t_s) const;
  Eigen::Vector2d InPlane(const geo::LatLon& position) const;
  // How far the track comes from where it was at the first of these times.
  double WayM(const std::vector<double>& times_s) const;
  // Photos beyond an end of it follow those that it covers without a pause. Times rising, here and below.
  bool PhotosRunOn(const std::vector<double>& times_s) const;
  // Photos of the ground beside a log from take-off to landing: taken long before or after, or by a camera
  // that ran all the while. Those that run on beyond one end say that the clock is wrong.
  bool AreOthersOfGround(const std::vector<double>& times_s) const;
  // Where a log ends at rest, photos beyond it say that the clock is wrong.
  bool IsCutWhereItLacks(const std::vector<double>& times_s) const;

 private:
  // The log ends, or begins, in motion there: it was cut, or covers only a part of the flight.
  bool IsCutNear(double t_s) const;

  std::vector<LogSpan> stretches_;
  std::optional<geo::LocalFrame> frame_;
  std::vector<double> times_s_;
  std::vector<Eigen::Vector2d> positions_m_;
};

}  // namespace skyquilt::poses
