#include "tests/bench/poses/real_logs.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <vector>

#include "core/flight/logs/read_log.h"
#include "core/poses/attitude_convention.h"
#include "core/poses/recorded_series.h"
#include "core/poses/smoother_input.h"
#include "core/poses/strapdown.h"

namespace skyquilt::bench {
namespace {

using Eigen::Vector3d;

// GNSS position and velocity at a time, between the two fixes around it; nothing across holes.
struct GnssAt {
  Vector3d position;
  Vector3d velocity;
};
std::optional<GnssAt> Interpolate(const poses::GnssSeries& gnss, double t) {
  const auto& p = gnss.positions;
  const auto next = std::upper_bound(p.begin(), p.end(), t,
                                     [](double x, const poses::PositionFix& f) { return x < f.t_s; });
  if (next == p.begin() || next == p.end() || next->t_s - (next - 1)->t_s > 0.6) return std::nullopt;
  const auto i = static_cast<std::size_t>(next - p.begin());
  if (gnss.velocities.size() != p.size()) return std::nullopt;
  const double w = (t - p[i - 1].t_s) / (p[i].t_s - p[i - 1].t_s);
  return GnssAt{
      (1.0 - w) * p[i - 1].position_in_enu_m + w * p[i].position_in_enu_m,
      (1.0 - w) * gnss.velocities[i - 1].velocity_in_enu_mps + w * gnss.velocities[i].velocity_in_enu_mps};
}

// Windows in flight: the start times, ten seconds apart, from which `length_s` of samples without holes
// follow.
std::vector<double> Windows(const flight::FlightLog& log, const poses::GnssSeries& gnss, double length_s) {
  std::vector<double> starts;
  const double first = log.imu.front().t_s;
  const double last = log.imu.back().t_s;
  for (double t = first + 5.0; t + length_s < last - 5.0; t += 10.0) {
    const auto begin = std::lower_bound(log.imu.begin(), log.imu.end(), t,
                                        [](const flight::ImuSample& s, double x) { return s.t_s < x; });
    bool good = Interpolate(gnss, t) && Interpolate(gnss, t + length_s);
    double height = 1e9;
    for (auto s = begin; good && s + 1 != log.imu.end() && s->t_s < t + length_s; ++s) {
      good = (s + 1)->t_s - s->t_s < 0.2;
    }
    for (const flight::BaroSample& b : log.baro) {
      if (b.t_s > t && b.t_s < t + length_s) height = std::min(height, b.height_above_takeoff_m);
    }
    if (good && height > 3.0 && height < 1e8) starts.push_back(t);
  }
  return starts;
}

// Horizontal error after `length_s` of double integration with the autopilot's attitude.
std::optional<double> Reckon(const flight::FlightLog& log, const std::vector<poses::AttitudeFix>& attitudes,
                             const poses::GnssSeries& gnss, double begin_s, double length_s, double gravity) {
  std::vector<flight::ImuSample> samples;
  std::vector<Eigen::Quaterniond> rotations;
  for (const flight::ImuSample& s : log.imu) {
    if (s.t_s < begin_s || s.t_s > begin_s + length_s) continue;
    const auto next = std::upper_bound(attitudes.begin(), attitudes.end(), s.t_s,
                                       [](double t, const poses::AttitudeFix& a) { return t < a.t_s; });
    if (next == attitudes.begin() || next == attitudes.end()) return std::nullopt;
    const auto before = next - 1;
    rotations.push_back(
        before->enu_from_body.slerp((s.t_s - before->t_s) / (next->t_s - before->t_s), next->enu_from_body));
    samples.push_back(s);
  }
  if (samples.size() < 2) return std::nullopt;
  const auto start = Interpolate(gnss, samples.front().t_s);
  const auto end = Interpolate(gnss, samples.back().t_s);
  if (!start || !end) return std::nullopt;
  poses::StrapdownState state;
  state.position_in_enu_m = start->position;
  state.velocity_in_enu_mps = start->velocity;
  poses::StrapdownOptions options;
  options.gravity_mps2 = gravity;
  const auto path = poses::IntegrateStrapdownWithAttitude(samples, rotations, state, options);
  if (!path.ok()) return std::nullopt;
  return (path->back().position_in_enu_m - end->position).head<2>().norm();
}

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
  const auto attitudes = poses::AttitudesOfLog(log->attitude);
  const double gravity = poses::NormalGravityMps2(first.position.lat_deg, first.height_amsl_m.value_or(0.0));
  const double references[] = {8.0, 57.0, 210.0};
  int row = 0;
  for (const double length : {10.0, 30.0, 60.0}) {
    double squares = 0.0;
    int count = 0;
    for (const double t : Windows(*log, gnss, length)) {
      const auto error = Reckon(*log, attitudes, gnss, t, length, gravity);
      if (!error) continue;
      squares += *error * *error;
      ++count;
    }
    fmt::print("  dead reckoning {:>2.0f} s: {:>7.1f} m RMS of {} windows (reference about {:.0f} m)\n",
               length, std::sqrt(squares / std::max(1, count)), count, references[row++]);
  }
  poses::FlightSources sources;
  sources.log = &*log;
  const poses::PreparedSmoothing prepared = poses::MakeSmootherInput(sources, frame);
  row = 0;
  const double bridged[] = {0.8, 2.1};
  for (const double length : {10.0, 30.0}) {
    Bridge mean;
    int count = 0;
    for (const double t : Windows(*log, gnss, length)) {
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
