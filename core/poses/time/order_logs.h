// OrderLogs: which of several logs leads (join_logs.h): the one with the most kinds of series. Where two
// tracks are of the same time, or logs lie days apart, each is tied to the photos by itself: one that stands
// while they are taken comes last, one that can be tied, covers more of them, lies nearer to where they say
// they were, and states the smaller error comes first. Pure; deterministic; any thread. Costs a tie for each
// log where there is something to choose.
#pragma once

#include <limits>
#include <vector>

#include "core/flight/logs/flight_log.h"
#include "core/flight/photo.h"
#include "core/flight/remarks/remark.h"
#include "core/poses/log_span.h"

namespace skyquilt::poses {

// Kinds of series, the inertial and attitude ones before all: they are what no other file can give.
int Worth(const flight::FlightLog& log);

LogSpan SpanOfEvents(const flight::FlightLog& log, LogSpan span = {});
LogSpan SpanOf(const flight::FlightLog& log);  // of its series
LogSpan SpanWithEvents(const flight::FlightLog& log);

bool IsMostlyFixed(const std::vector<flight::GnssSample>& samples);

// What a log is to the photos. `is_compared`: false where there was nothing to choose, and all else is unset.
struct LogMerit {
  bool is_compared = false;
  bool moves = false;   // while photos are taken
  bool stands = false;  // then, while another log's track moves
  bool ties = false;    // to the photos, on a day that their clock can mean
  int worth = 0;
  int covered_tenths = 0;                                    // of the photos
  int near_tenths = 0;                                       // of the photos that know where they were
  bool is_fixed = false;                                     // its track is corrected
  double sigma_m = std::numeric_limits<double>::infinity();  // as it states
};

struct RankedLog {
  const flight::FlightLog* log = nullptr;
  LogMerit merit;
};
std::vector<RankedLog> OrderLogs(const std::vector<const flight::FlightLog*>& logs,
                                 const std::vector<flight::Photo>& photos);

// Why the track of one is used rather than that of another.
flight::Remark WhyBefore(const LogMerit& used, const LogMerit& other);

// Logs of the flight of these photos lie no further apart than this.
double MostApartS(const std::vector<flight::Photo>& photos);

// Between the two; 0 where they meet.
double HoleBetweenS(const LogSpan& a, const LogSpan& b);

}  // namespace skyquilt::poses
