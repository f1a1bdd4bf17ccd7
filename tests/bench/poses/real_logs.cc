#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "core/flight/logs/read_log.h"
#include "core/poses/evidence/smoother_input.h"
#include "tests/bench/poses/reckon.h"
#include "tests/bench/poses/tables.h"

namespace skyquilt::bench {
namespace {

// Horizontal distance between the smoother's track with all fixes and without those of [begin, begin +
// length], over that hole, and the sigma that the latter states.
struct Bridge {
  double rms_m = 0.0;
  double largest_m = 0.0;
  double sigma_m = 0.0;
};
std::optional<Bridge> BridgeHole(const poses::SmootherInput& all, double begin_s, double length_s) {
  poses::SmootherInput full = all;
  full.photo_times_s.clear();
  for (double t = begin_s; t <= begin_s + length_s; t += 1.0) full.photo_times_s.push_back(t);
  poses::SmootherInput holed = full;
  const auto in_hole = [&](const auto& f) { return f.t_s > begin_s && f.t_s < begin_s + length_s; };
  std::erase_if(holed.positions, in_hole);
  std::erase_if(holed.velocities, in_hole);
  const auto a = poses::SmoothChain(full);
  const auto b = poses::SmoothChain(holed);
  if (!a.ok() || !b.ok()) return std::nullopt;
  Bridge bridge;
  const double n = static_cast<double>(a->poses.size());
  for (std::size_t k = 0; k < a->poses.size(); ++k) {
    const double d = (a->poses[k].position_in_enu_m - b->poses[k].position_in_enu_m).head<2>().norm();
    bridge.largest_m = std::max(bridge.largest_m, d);
    bridge.rms_m += d * d / n;
    bridge.sigma_m += b->poses[k].covariance.diagonal().segment<2>(3).sum() / n;
  }
  bridge.rms_m = std::sqrt(bridge.rms_m);
  bridge.sigma_m = std::sqrt(bridge.sigma_m);
  return bridge;
}

void PrintLog(const std::filesystem::path& path) {
  const auto log = flight::ReadLog({path.filename().string(), path});
  if (!log.ok()) {
    fmt::print("{}: {}\n", path.filename().string(), log.error().message);
    return;
  }
  fmt::print("{}: {} inertial, {} attitude, {} GNSS, {} barometer samples\n", log->file_name, log->imu.size(),
             log->attitude.size(), log->gnss.size(), log->baro.size());
  if (log->imu.size() < 1000 || log->gnss.size() < 100 || log->attitude.empty()) {
    fmt::print("  too short for drift figures\n");
    return;
  }
  const flight::GnssSample& first = log->gnss[log->gnss.size() / 2];
  const geo::LocalFrame frame(
      {first.position.lat_deg, first.position.lon_deg, first.height_amsl_m.value_or(0.0)});
  const poses::GnssSeries gnss = poses::GnssOfLog(log->gnss, frame);
  const auto drifts = poses::DriftsOfReckoning(*log);
  if (!drifts) {
    fmt::print("  {}\n", drifts.error().message);
    return;
  }
  const double references[] = {8.0, 57.0, 210.0};
  int row = 0;
  for (const poses::ReckonedDrift& drift : *drifts) {
    fmt::print(
        "  dead reckoning {:>2.0f} s: {:>7.1f} m RMS, {:.1f} by Simpson's rule, of {} windows (reference about {:.0f} m)\n",
        drift.length_s, drift.trapezoid_rms_m, drift.simpson_rms_m, drift.windows, references[row++]);
  }
  poses::FlightSources sources;
  sources.log = &*log;
  const poses::PreparedSmoothing prepared = poses::MakeSmootherInput(sources, frame);
  row = 0;
  const double bridged[] = {0.8, 2.1};
  for (const double length : {10.0, 30.0}) {
    Bridge mean;
    int count = 0;
    for (const double t : poses::WindowsInFlight(*log, gnss, length)) {
      const auto bridge = BridgeHole(prepared.input, t, length);
      if (!bridge) continue;
      mean.rms_m += bridge->rms_m * bridge->rms_m;
      mean.largest_m += bridge->largest_m * bridge->largest_m;
      mean.sigma_m += bridge->sigma_m * bridge->sigma_m;
      ++count;
    }
    const double n = std::max(1, count);
    fmt::print(
        "  smoother over {} holes of {:>2.0f} s: {:.2f} m RMS, {:.2f} m where it is largest (reference "
        "{:.1f} m), "
        "stated 1-sigma {:.2f} m\n",
        count, length, std::sqrt(mean.rms_m / n), std::sqrt(mean.largest_m / n), bridged[row++],
        std::sqrt(mean.sigma_m / n));
  }
}

}  // namespace

void PrintRealLogs(const std::string& folder) {
  fmt::print("Real logs\n");
  std::vector<std::filesystem::path> paths;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    if (entry.is_regular_file()) paths.push_back(entry.path());
  }
  if (paths.empty()) {
    fmt::print("  none in '{}'; give their folder as the second argument\n\n", folder);
    return;
  }
  std::sort(paths.begin(), paths.end());
  for (const auto& path : paths) PrintLog(path);
  fmt::print("\n");
}

}  // namespace skyquilt::bench
