#include "tests/bench/poses/reckon.h"

#include <algorithm>
#include <cmath>

#include "core/geo/local_frame.h"

namespace skyquilt::poses {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kMaxFixGapS = 0.6;     // between the two fixes that a state lies between
constexpr double kMaxSampleGapS = 0.2;  // between inertial samples
constexpr double kWindowEveryS = 10.0;
constexpr double kInFlightAboveM = 3.0;
constexpr double kDriftLengthsS[] = {10.0, 30.0, 60.0};

// What the log's own estimates say, in one frame.
struct Recorded {
  GnssSeries gnss;
  std::vector<AttitudeFix> attitudes;
  double gravity_mps2 = kStandardGravityMps2;
};

struct GnssState {
  Vector3d position_in_enu_m;
  Vector3d velocity_in_enu_mps;
};

// Between the two fixes around `t_s`; nothing across holes.
std::optional<GnssState> GnssAt(const GnssSeries& gnss, double t_s) {
  const auto& fixes = gnss.positions;
  const auto next = std::upper_bound(fixes.begin(), fixes.end(), t_s,
                                     [](double t, const PositionFix& fix) { return t < fix.t_s; });
  if (next == fixes.begin() || next == fixes.end() || next->t_s - (next - 1)->t_s > kMaxFixGapS) {
    return std::nullopt;
  }
  if (gnss.velocities.size() != fixes.size()) return std::nullopt;
  const auto i = static_cast<std::size_t>(next - fixes.begin());
  const double w = (t_s - fixes[i - 1].t_s) / (fixes[i].t_s - fixes[i - 1].t_s);
  return GnssState{
      (1.0 - w) * fixes[i - 1].position_in_enu_m + w * fixes[i].position_in_enu_m,
      (1.0 - w) * gnss.velocities[i - 1].velocity_in_enu_mps + w * gnss.velocities[i].velocity_in_enu_mps};
}

std::optional<Quaterniond> AttitudeAt(const std::vector<AttitudeFix>& attitudes, double t_s) {
  const auto next = std::upper_bound(attitudes.begin(), attitudes.end(), t_s,
                                     [](double t, const AttitudeFix& fix) { return t < fix.t_s; });
  if (next == attitudes.begin() || next == attitudes.end()) return std::nullopt;
  const auto before = next - 1;
  return before->enu_from_body.slerp((t_s - before->t_s) / (next->t_s - before->t_s), next->enu_from_body);
}

// Samples of [begin, end]; nothing where there is a hole between them.
std::vector<flight::ImuSample> SamplesOf(const std::vector<flight::ImuSample>& imu, double begin_s,
                                         double end_s) {
  const auto is_before = [](const flight::ImuSample& sample, double t) { return sample.t_s < t; };
  auto sample = std::lower_bound(imu.begin(), imu.end(), begin_s, is_before);
  std::vector<flight::ImuSample> samples;
  for (; sample != imu.end() && sample->t_s <= end_s; ++sample) {
    if (!samples.empty() && sample->t_s - samples.back().t_s >= kMaxSampleGapS) return {};
    samples.push_back(*sample);
  }
  if (samples.size() < 2 || samples.front().t_s - begin_s > kMaxSampleGapS ||
      end_s - samples.back().t_s > kMaxSampleGapS) {
    return {};
  }
  return samples;
}

// Horizontal error of double integration with the autopilot's attitude, from the recorded state.
std::optional<double> DriftOver(const Recorded& recorded, const std::vector<flight::ImuSample>& samples,
                                IntegrationRule rule) {
  std::vector<Quaterniond> enu_from_body;
  for (const flight::ImuSample& sample : samples) {
    const auto attitude = AttitudeAt(recorded.attitudes, sample.t_s);
    if (!attitude) return std::nullopt;
    enu_from_body.push_back(*attitude);
  }
  const auto start = GnssAt(recorded.gnss, samples.front().t_s);
  if (!start) return std::nullopt;
  StrapdownState state;
  state.position_in_enu_m = start->position_in_enu_m;
  state.velocity_in_enu_mps = start->velocity_in_enu_mps;
  StrapdownOptions options;
  options.rule = rule;
  options.gravity_mps2 = recorded.gravity_mps2;
  const auto path = IntegrateStrapdownWithAttitude(samples, enu_from_body, state, options);
  if (!path) return std::nullopt;
  const auto end = GnssAt(recorded.gnss, path->back().t_s);
  if (!end) return std::nullopt;
  return (path->back().position_in_enu_m - end->position_in_enu_m).head<2>().norm();
}

std::vector<ReckonedDrift> Drifts(const flight::FlightLog& log, const Recorded& recorded) {
  std::vector<ReckonedDrift> drifts;
  for (const double length_s : kDriftLengthsS) {
    ReckonedDrift drift{length_s, 0, 0.0, 0.0};
    for (const double t : WindowsInFlight(log, recorded.gnss, length_s)) {
      const auto samples = SamplesOf(log.imu, t, t + length_s);
      const auto trapezoid = DriftOver(recorded, samples, IntegrationRule::kTrapezoid);
      const auto simpson = DriftOver(recorded, samples, IntegrationRule::kSimpson);
      if (!trapezoid || !simpson) continue;
      ++drift.windows;
      drift.trapezoid_rms_m += *trapezoid * *trapezoid;
      drift.simpson_rms_m += *simpson * *simpson;
    }
    if (drift.windows == 0) continue;
    drift.trapezoid_rms_m = std::sqrt(drift.trapezoid_rms_m / drift.windows);
    drift.simpson_rms_m = std::sqrt(drift.simpson_rms_m / drift.windows);
    drifts.push_back(drift);
  }
  return drifts;
}

}  // namespace

std::vector<double> WindowsInFlight(const flight::FlightLog& log, const GnssSeries& gnss, double length_s) {
  constexpr double kMarginS = 5.0;
  std::vector<double> starts;
  const double first_s = log.imu.front().t_s;
  const double last_s = log.imu.back().t_s;
  for (double t = first_s + kMarginS; t + length_s < last_s - kMarginS; t += kWindowEveryS) {
    if (!GnssAt(gnss, t) || !GnssAt(gnss, t + length_s) || SamplesOf(log.imu, t, t + length_s).empty()) {
      continue;
    }
    std::optional<double> lowest_m;
    for (const flight::BaroSample& baro : log.baro) {
      if (baro.t_s <= t || baro.t_s >= t + length_s) continue;
      lowest_m = std::min(lowest_m.value_or(baro.height_above_takeoff_m), baro.height_above_takeoff_m);
    }
    if (lowest_m && *lowest_m > kInFlightAboveM) starts.push_back(t);
  }
  return starts;
}

Result<std::vector<ReckonedDrift>> DriftsOfReckoning(const flight::FlightLog& log) {
  const auto lacks = [&](const char* what) {
    return Error{ErrorCode::kUnprocessable,
                 "The log " + log.file_name + " holds no " + what +
                     ". Reckoning needs inertial samples, attitudes and GNSS positions of one flight.",
                 ""};
  };
  if (log.imu.size() < 2) return lacks("inertial samples");
  if (log.attitude.empty()) return lacks("attitudes");
  if (log.gnss.empty()) return lacks("GNSS positions");
  const flight::GnssSample& middle = log.gnss[log.gnss.size() / 2];
  const double height_m = middle.height_amsl_m.value_or(0.0);
  const geo::LocalFrame frame({middle.position.lat_deg, middle.position.lon_deg, height_m});
  const Recorded recorded{GnssOfLog(log.gnss, frame), AttitudesOfLog(log.attitude),
                          NormalGravityMps2(middle.position.lat_deg, height_m)};
  return Drifts(log, recorded);
}

}  // namespace skyquilt::poses
