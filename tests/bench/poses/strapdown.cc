#include "tests/bench/poses/strapdown.h"

#include <cmath>
#include <string>

#include "core/geo/rigid3.h"

namespace skyquilt::poses {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

Result<void> CheckSamples(const std::vector<flight::ImuSample>& samples) {
  if (samples.size() < 2) {
    return Error{ErrorCode::kUnprocessable,
                 "The inertial log has fewer than two samples; nothing can be integrated.", ""};
  }
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const flight::ImuSample& s = samples[i];
    if (!std::isfinite(s.t_s) || !s.angular_rate_radps.allFinite() || !s.specific_force_mps2.allFinite()) {
      return Error{ErrorCode::kUnprocessable,
                   "The inertial log holds a value that is not a number; drop that sample and try again.",
                   "sample " + std::to_string(i)};
    }
    if (i > 0 && !(s.t_s > samples[i - 1].t_s)) {
      return Error{
          ErrorCode::kUnprocessable,
          "The times of the inertial log do not rise; split it at the jump and drop repeated samples.",
          "sample " + std::to_string(i) + " at " + std::to_string(s.t_s) + " s"};
    }
  }
  return {};
}

Vector3d Rate(const flight::ImuSample& s, const StrapdownOptions& o) {
  return s.angular_rate_radps - o.gyro_bias_radps;
}
Vector3d Force(const flight::ImuSample& s, const StrapdownOptions& o) {
  return s.specific_force_mps2 - o.accel_bias_mps2;
}

bool IsEvenPair(const std::vector<flight::ImuSample>& samples, std::size_t first) {
  if (first + 2 >= samples.size()) return false;
  const double h0 = samples[first + 1].t_s - samples[first].t_s;
  const double h1 = samples[first + 2].t_s - samples[first + 1].t_s;
  return std::abs(h1 - h0) <= 0.01 * h0;
}

// The rotation over one step: the integral of the rate plus the second term of the Magnus series for a rate
// that runs linearly from w0 to w1.
Quaterniond StepRotation(const Vector3d& integral, const Vector3d& w0, const Vector3d& w1, double h) {
  return geo::RotationFromVector(integral + (h * h / 12.0) * w0.cross(w1));
}

std::vector<Quaterniond> Rotations(const std::vector<flight::ImuSample>& samples, const Quaterniond& first,
                                   const StrapdownOptions& options) {
  std::vector<Quaterniond> enu_from_body(samples.size());
  enu_from_body[0] = first;
  std::size_t i = 0;
  while (i + 1 < samples.size()) {
    const double h = samples[i + 1].t_s - samples[i].t_s;
    const Vector3d w0 = Rate(samples[i], options);
    const Vector3d w1 = Rate(samples[i + 1], options);
    if (options.rule == IntegrationRule::kSimpson && IsEvenPair(samples, i)) {
      // Both halves of the parabola through three rates.
      const Vector3d w2 = Rate(samples[i + 2], options);
      const Vector3d near = (h / 12.0) * (5.0 * w0 + 8.0 * w1 - w2);
      const Vector3d far = (h / 12.0) * (-w0 + 8.0 * w1 + 5.0 * w2);
      enu_from_body[i + 1] = (enu_from_body[i] * StepRotation(near, w0, w1, h)).normalized();
      enu_from_body[i + 2] = (enu_from_body[i + 1] * StepRotation(far, w1, w2, h)).normalized();
      i += 2;
      continue;
    }
    enu_from_body[i + 1] = (enu_from_body[i] * StepRotation(0.5 * h * (w0 + w1), w0, w1, h)).normalized();
    ++i;
  }
  return enu_from_body;
}

// Acceleration in enu of every sample, given every sample's rotation.
std::vector<Vector3d> Accelerations(const std::vector<flight::ImuSample>& samples,
                                    const std::vector<Quaterniond>& enu_from_body,
                                    const StrapdownOptions& options) {
  const Vector3d gravity(0.0, 0.0, -options.gravity_mps2);
  std::vector<Vector3d> accelerations(samples.size());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    accelerations[i] = enu_from_body[i] * Force(samples[i], options) + gravity;
  }
  return accelerations;
}

// Over [0, h] with the acceleration linear from a0 to a1.
void TrapezoidStep(const Vector3d& a0, const Vector3d& a1, double h, StrapdownState& state) {
  state.position_in_enu_m += h * state.velocity_in_enu_mps + (h * h / 6.0) * (2.0 * a0 + a1);
  state.velocity_in_enu_mps += 0.5 * h * (a0 + a1);
}

// Over [0, 2h] with the acceleration the parabola through three samples; the velocity gain is Simpson's rule.
void SimpsonStep(const Vector3d& a0, const Vector3d& a1, const Vector3d& a2, double h,
                 StrapdownState& state) {
  state.position_in_enu_m += 2.0 * h * state.velocity_in_enu_mps + (2.0 * h * h / 3.0) * (a0 + 2.0 * a1);
  state.velocity_in_enu_mps += (h / 3.0) * (a0 + 4.0 * a1 + a2);
}

std::vector<StrapdownState> Sum(const std::vector<flight::ImuSample>& samples,
                                const std::vector<Quaterniond>& enu_from_body, const std::vector<Vector3d>& a,
                                const StrapdownState& start, IntegrationRule rule) {
  std::vector<StrapdownState> states;
  states.reserve(samples.size());
  StrapdownState state = start;
  const auto keep = [&](std::size_t i) {
    state.t_s = samples[i].t_s;
    state.enu_from_body = enu_from_body[i];
    states.push_back(state);
  };
  keep(0);
  std::size_t i = 0;
  while (i + 1 < samples.size()) {
    const double h = samples[i + 1].t_s - samples[i].t_s;
    if (rule == IntegrationRule::kSimpson && IsEvenPair(samples, i)) {
      SimpsonStep(a[i], a[i + 1], a[i + 2], 0.5 * (samples[i + 2].t_s - samples[i].t_s), state);
      i += 2;
      keep(i);
      continue;
    }
    TrapezoidStep(a[i], a[i + 1], h, state);
    ++i;
    keep(i);
  }
  return states;
}

}  // namespace

Result<std::vector<StrapdownState>> IntegrateStrapdown(const std::vector<flight::ImuSample>& samples,
                                                       const StrapdownState& start,
                                                       const StrapdownOptions& options) {
  if (Result<void> good = CheckSamples(samples); !good.ok()) return good.error();
  const std::vector<Quaterniond> enu_from_body =
      Rotations(samples, start.enu_from_body.normalized(), options);
  return Sum(samples, enu_from_body, Accelerations(samples, enu_from_body, options), start, options.rule);
}

Result<std::vector<StrapdownState>> IntegrateStrapdownWithAttitude(
    const std::vector<flight::ImuSample>& samples, const std::vector<Quaterniond>& enu_from_body,
    const StrapdownState& start, const StrapdownOptions& options) {
  if (Result<void> good = CheckSamples(samples); !good.ok()) return good.error();
  if (enu_from_body.size() != samples.size()) {
    return Error{ErrorCode::kInvalidArgument, "There must be one attitude for each inertial sample.", ""};
  }
  return Sum(samples, enu_from_body, Accelerations(samples, enu_from_body, options), start, options.rule);
}

}  // namespace skyquilt::poses
