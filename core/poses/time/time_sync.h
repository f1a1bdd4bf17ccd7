// MatchPhotosToLog: when, on the log's clock, each photo was taken, and which camera event it is.
// In this order: names that events carry; as many events as photos; the pattern of intervals where some
// events were lost or doubled, of several shifts that fit as well the one by which the photos' own positions
// are those of the events; without events, the offset of the camera's clock from positions of the photos
// against the track, from distances between photos, or from the two clocks as they stand. Stamps cut to whole
// seconds are first refined by the constant trigger interval. What was done is said in words, with a sigma;
// ambiguity raises the sigma. Photos in the order of capture. Deterministic; any thread. Error:
// kUnprocessable when nothing ties the two together, with advice; also where positions of events are all that
// the log has, and several shifts of them fit as well.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/flight/logs/flight_log.h"
#include "core/flight/photo.h"

namespace skyquilt::poses {

enum class TimeSyncMethod { kEventNames, kEventCount, kEventPattern, kPositions, kDistances, kClocks };

struct PhotoTime {
  double t_s = 0.0;  // on the log's clock
  double sigma_s = 0.0;
  std::optional<std::size_t> event;  // index into FlightLog::events
};

struct TimeSync {
  TimeSyncMethod method = TimeSyncMethod::kClocks;
  std::string method_in_words;
  // Log time of a photo = its stamp - the first stamp + offset_s. Meaningless where no photo has a stamp.
  double offset_s = 0.0;
  double sigma_s = 0.0;
  // By how much the camera's clock is ahead of UTC, where the log knows UTC and photos have stamps.
  std::optional<double> camera_ahead_of_utc_s;
  std::vector<std::optional<PhotoTime>>
      photos;  // as the photos given; nothing where a photo could not be placed
  std::vector<std::string> notes;
};

struct TimeSyncOptions {
  double trigger_jitter_s = 0.02;     // between a measured shutter and the exposure, 1 sigma
  double command_jitter_s = 0.05;     // between a command and the exposure, 1 sigma
  double camera_clock_sigma_s = 2.0;  // of a camera's clock that claims UTC and is not checked by anything
  // Distances between consecutive photos from image matching, where there are: one fewer than photos.
  std::vector<std::optional<double>> distance_to_next;
  bool distances_in_metres = false;

  Result<void> Validate() const;
};

Result<TimeSync> MatchPhotosToLog(const std::vector<flight::Photo>& photos, const flight::FlightLog& log,
                                  const TimeSyncOptions& options = {});

}  // namespace skyquilt::poses
