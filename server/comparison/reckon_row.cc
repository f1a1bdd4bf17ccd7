#include "server/comparison/reckon_row.h"

#include <fmt/format.h>

#include <chrono>
#include <ctime>

#include "core/base/median.h"
#include "core/base/progress.h"
#include "core/poses/reckoning/reckon.h"
#include "core/poses/time/join_logs.h"
#include "core/poses/time/tie_to_log.h"

namespace skyquilt::server {

std::optional<MethodOutcome> ReckonRow(const std::vector<flight::InputFile>& files) {
  const auto start = std::chrono::steady_clock::now();
  const std::clock_t cpu_start = std::clock();
  SilentProgress progress;
  const auto flight = flight::ReadFlight(files, {}, progress);
  if (!flight) return std::nullopt;  // the methods' rows say why
  const auto joined = poses::JoinLogs(flight->logs, flight->photos);
  if (!joined || joined->log.imu.empty()) return std::nullopt;
  const poses::LogTie tie = poses::TieToLog(joined->log, flight->photos);
  std::vector<poses::Capture> captures;
  for (const poses::TiedPhoto& photo : tie.tied)
    captures.push_back({photo.t_s, tie.photos[photo.photo].name});
  const auto reckoning = poses::ReckonBetween(joined->log, captures);
  if (!reckoning || reckoning->intervals.empty()) return std::nullopt;
  std::vector<double> trapezoid_m, simpson_m;
  for (const poses::ReckonedInterval& interval : reckoning->intervals) {
    trapezoid_m.push_back(interval.trapezoid.drift_m);
    simpson_m.push_back(interval.simpson.drift_m);
  }
  MethodOutcome outcome;
  outcome.method = "reckon";
  outcome.photos = static_cast<int>(flight->photos.size());
  outcome.note = fmt::format(
      "drift between captures {:.3f} m by trapezoid, {:.3f} m by Simpson (median of {} intervals)",
      Median(trapezoid_m), Median(simpson_m), reckoning->intervals.size());
  outcome.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  outcome.cpu_s = static_cast<double>(std::clock() - cpu_start) / CLOCKS_PER_SEC;
  return outcome;
}

}  // namespace skyquilt::server
