// MatchPhotosToLog: when, on the log's clock, each photo was taken, and which camera event it is.
// In this order: names that events carry; as many events as photos; the pattern of intervals where some
// events were lost or doubled, of several shifts that fit as well the one by which the photos' own positions
// are those of the events; without events, the offset of the camera's clock from positions of the photos
// against the track, or from the two clocks as they stand. Stamps cut to whole seconds are first refined by
// the constant trigger interval. What was done is said in words, with a sigma; ambiguity raises the sigma.
// Photos in the order of capture. Deterministic; any thread. Error: kUnprocessable when nothing ties the two
// together, with advice; also where positions of events are all that the log has, and several shifts of them
// fit as well, and where photos with the receiver's time would have been taken on another day than the log.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/flight/logs/flight_log.h"
#include "core/flight/photo.h"
#include "core/flight/remarks/remark.h"

namespace skyquilt::poses {

// Of a tie by clocks whose zone stays open: the next that fits is a quarter of an hour away, or more.
inline constexpr double kOpenClockSigmaS = 900.0;

enum class TimeSyncMethod { kEventNames, kEventCount, kEventPattern, kPositions, kClocks };

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
  std::vector<flight::Remark> warnings;
};

Result<TimeSync> MatchPhotosToLog(const std::vector<flight::Photo>& photos, const flight::FlightLog& log);

}  // namespace skyquilt::poses
