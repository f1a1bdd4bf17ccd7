// JoinLogs: the logs of one flight on one clock. People bring several: the autopilot's log beside a list of
// exposures (MRK), a corrected track (RTKLIB) beside the recorder's own, one log a battery. The log with the
// most kinds of series leads; the others are shifted by their UTC (tables without one by the seconds that
// both count) and give what it lacks, a better position, or the time it does not cover. Lists that name
// photos without saying when (geo.txt, geolocation CSV) are no part of it: ApplyPhotoRows takes them. Seconds
// on the leading log's clock. Pure; any thread.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/flight/logs/flight_log.h"
#include "core/flight/photo.h"
#include "core/flight/remarks/remark.h"
#include "core/poses/log_span.h"

namespace skyquilt::poses {

struct JoinedLog {
  flight::FlightLog log;
  std::vector<std::string> notes;        // what came from which file, in words
  std::vector<flight::Remark> warnings;  // what could not be used
};

// Logs in which nothing is that a photo could be placed by.
std::vector<flight::Remark> WarnOfEmptyLogs(const std::vector<flight::FlightLog>& logs);

// Nothing where no log has a series or an event with a time. `photos`: lists of positions that are those of
// camera events (event_list.h) are known by them.
std::optional<JoinedLog> JoinLogs(const std::vector<flight::FlightLog>& logs,
                                  const std::vector<flight::Photo>& photos);

}  // namespace skyquilt::poses
