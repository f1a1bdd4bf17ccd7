// The offset between a camera's clock and a log's, found on the track itself where no events help: the offset
// at which the photos' own positions fit the log's track best. Constant-speed legs say nothing about time;
// turns, stops and changes of speed do, and the sigma shows it. Pure functions; any thread; deterministic.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

namespace skyquilt::poses {

// Horizontal track of a log in a local plane, rising times.
struct TrackPoint {
  double t_s = 0.0;
  Eigen::Vector2d position_m = Eigen::Vector2d::Zero();
};

// Position at a time; nothing outside the track and in its gaps of more than two seconds.
std::optional<Eigen::Vector2d> TrackAt(std::span<const TrackPoint> track, double t_s);

struct ClockOffset {
  double offset_s = 0.0;  // add to the photo's time to get the log's
  double sigma_s = 0.0;
  double residual_m = 0.0;  // robust, of one photo
};

// Photos with a position in the same plane. Every offset that keeps four fifths of them on the track is
// tried.
struct TimedPosition {
  double t_s = 0.0;  // on the camera's clock
  Eigen::Vector2d position_m = Eigen::Vector2d::Zero();
};
std::optional<ClockOffset> SearchByPositions(std::span<const TimedPosition> photos,
                                             std::span<const TrackPoint> track);

}  // namespace skyquilt::poses
