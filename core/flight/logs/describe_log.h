// DescribeLog: what a log holds, for people: every series with its count, rate and longest gap, and when it
// was recorded. Seconds on the log's own clock. Pure; any thread.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/flight/logs/flight_log.h"

namespace skyquilt::flight {

struct SeriesFacts {
  std::size_t count = 0;
  double rate_hz = 0.0;  // by the median step; 0 for fewer than two samples
  double longest_gap_s = 0.0;
  double begin_s = 0.0;
  double end_s = 0.0;
};

struct LogFacts {
  std::string file_name;
  std::string format;
  std::map<std::string, SeriesFacts> series;  // "imu", "attitude", "gnss", ...; only those that are there
  std::map<std::string, std::uint64_t> message_counts;  // by the format's own names
  std::string begins_at;             // UTC of its first sample, ISO 8601; empty where it does not know
  int events_by_name = 0;            // rows that name a photo without saying when
  std::vector<std::string> mapping;  // of tolerant formats: what each column was taken for
  std::vector<std::string> advice;   // what is wrong with it for mapping, and what to do
};

LogFacts DescribeLog(const FlightLog& log);

}  // namespace skyquilt::flight
