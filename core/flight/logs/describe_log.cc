#include "core/flight/logs/describe_log.h"

#include <fmt/core.h>

#include <algorithm>

#include "core/base/median.h"
#include "core/flight/bytes/written_time.h"

namespace skyquilt::flight {
namespace {

template <typename Sample>
void Add(const char* name, const std::vector<Sample>& samples, LogFacts& all) {
  if (samples.empty()) return;
  SeriesFacts& facts = all.series[name];
  facts.count = samples.size();
  facts.begin_s = samples.front().t_s;
  facts.end_s = samples.back().t_s;
  std::vector<double> steps;
  for (std::size_t k = 1; k < samples.size(); ++k) {
    steps.push_back(samples[k].t_s - samples[k - 1].t_s);
    facts.longest_gap_s = std::max(facts.longest_gap_s, steps.back());
  }
  const double step_s = MedianIfAny(std::move(steps)).value_or(0.0);
  if (step_s > 0.0) facts.rate_hz = 1.0 / step_s;
}

void Advise(const FlightLog& log, LogFacts& facts) {
  const auto find = [&](const char* name) -> const SeriesFacts* {
    const auto found = facts.series.find(name);
    return found == facts.series.end() ? nullptr : &found->second;
  };
  const auto advise = [&](std::string text) { facts.advice.push_back(std::move(text)); };
  const SeriesFacts* imu = find("imu");
  if (imu != nullptr && imu->rate_hz < 20.0) {
    advise(fmt::format(
        "inertial samples come {:.0f} times a second, too slow to be summed; log them at 50 or more "
        "(ArduPilot: LOG_BITMASK with IMU_FAST or raw IMU)",
        imu->rate_hz));
  } else if (imu != nullptr && imu->rate_hz < 80.0) {
    advise(fmt::format(
        "inertial samples come {:.0f} times a second: vibration folds into them, and they are given less "
        "weight; 200 or more would be better",
        imu->rate_hz));
  }
  if (imu != nullptr && imu->longest_gap_s > 0.2) {
    advise(fmt::format("inertial samples have a gap of {:.1f} s; the track is bridged there, not summed",
                       imu->longest_gap_s));
  }
  const SeriesFacts* gnss = find("gnss");
  if (gnss != nullptr && gnss->longest_gap_s > 3.0) {
    advise(fmt::format("positions have a gap of {:.0f} s; the error grows there", gnss->longest_gap_s));
  }
  if (!facts.series.empty() && gnss == nullptr && find("events") == nullptr) {
    advise("no positions: the flight can only be reckoned from its start");
  }
  if (!facts.series.empty() && !log.utc_at_zero) {
    advise(
        log.local_at_zero
            ? "its clock is local, of no known zone: photos are tied to it by their clocks, whole quarter hours "
              "apart, if nothing better does"
            : "it knows no time of day: photos are tied to it by its camera events or their own positions");
  }
}

}  // namespace

LogFacts DescribeLog(const FlightLog& log) {
  LogFacts facts;
  facts.file_name = log.file_name;
  facts.format = log.format;
  facts.mapping = log.mapping;
  facts.message_counts = log.message_counts;
  Add("imu", log.imu, facts);
  Add("attitude", log.attitude, facts);
  Add("gnss", log.gnss, facts);
  Add("baro", log.baro, facts);
  Add("range", log.range, facts);
  Add("gimbal", log.gimbal, facts);
  std::vector<CameraEvent> timed;
  for (const CameraEvent& event : log.events) {
    if (event.has_time) {
      timed.push_back(event);
    } else {
      ++facts.events_by_name;
    }
  }
  Add("events", timed, facts);
  double begin_s = 1e18;
  for (const auto& [name, series] : facts.series) begin_s = std::min(begin_s, series.begin_s);
  if (log.utc_at_zero && !facts.series.empty()) {
    facts.begins_at = WrittenSecond(LaterBy(*log.utc_at_zero, begin_s)) + "Z";
  }
  Advise(log, facts);
  return facts;
}

}  // namespace skyquilt::flight
