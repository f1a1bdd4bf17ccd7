// TieToLog: which photos a log covers and when, on its clock, each was taken; with what the log's camera
// events say of them. A value; pure; any thread. What could not be tied is said in the warnings.
#pragma once

#include <optional>
#include <vector>

#include "core/flight/remarks/remark.h"
#include "core/poses/time/join_logs.h"
#include "core/poses/time/time_sync.h"

namespace skyquilt::poses {

struct TiedPhoto {
  std::size_t photo = 0;  // index into LogTie::photos
  double t_s = 0.0;       // on the log's clock
  double sigma_s = 0.0;   // of this photo's time alone
};

struct LogTie {
  std::vector<flight::Photo> photos;  // as given, with what camera events add
  std::vector<TiedPhoto> tied;        // that the log's series cover; times rising
  std::optional<TimeSync> sync;       // nothing where nothing ties the two together
  double clock_sigma_s = 0.0;         // of all times together; events are on the log's own clock
  std::vector<flight::Remark> warnings;
};

LogTie TieToLog(const flight::FlightLog& log, std::vector<flight::Photo> photos);

// Clockwise from north; nothing where the log has no heading within a second.
std::optional<double> AirframeYawAt(const flight::FlightLog& log, double t_s);

}  // namespace skyquilt::poses
