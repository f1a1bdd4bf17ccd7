#include "core/poses/smoother/preintegration.h"

#include <algorithm>
#include <cmath>

#include "core/geo/lat_lon.h"
#include "core/poses/so3.h"

namespace skyquilt::poses {

double NormalGravityMps2(double lat_deg, double height_ellipsoid_m) {
  const double sine = std::sin(geo::DegToRad(lat_deg));
  const double s2 = sine * sine;
  const double on_ellipsoid =
      9.7803253359 * (1.0 + 0.00193185265241 * s2) / std::sqrt(1.0 - geo::kWgs84EccentricitySquared * s2);
  return on_ellipsoid - 3.086e-6 * height_ellipsoid_m;
}

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

struct ImuReading {
  Vector3d rate;
  Vector3d force;
};

// Linear between the two samples around t; the end samples hold outside (callers bound how far).
ImuReading ReadingAt(const std::vector<flight::ImuSample>& samples, std::size_t next, double t) {
  if (next == 0) return {samples.front().angular_rate_radps, samples.front().specific_force_mps2};
  if (next >= samples.size()) return {samples.back().angular_rate_radps, samples.back().specific_force_mps2};
  const flight::ImuSample& a = samples[next - 1];
  const flight::ImuSample& b = samples[next];
  const double w = (t - a.t_s) / (b.t_s - a.t_s);
  return {(1.0 - w) * a.angular_rate_radps + w * b.angular_rate_radps,
          (1.0 - w) * a.specific_force_mps2 + w * b.specific_force_mps2};
}

void Step(const Vector3d& raw_rate, const Vector3d& raw_force, double dt, const ImuNoise& noise,
          Preintegration& sum) {
  ImuDelta& d = sum.delta;
  const Vector3d turn = (raw_rate - d.gyro_bias) * dt;
  const Vector3d force = raw_force - d.accel_bias;
  const Matrix3d half = d.rotation * ExpSo3(0.5 * turn);
  const Matrix3d step = ExpSo3(turn);
  const Matrix3d right = RightJacobian(turn) * dt;
  const Matrix3d turned_force = half * Skew(force);
  // How the rotation at the middle of the step depends on the gyro bias.
  const Matrix3d half_by_bias =
      ExpSo3(0.5 * turn).transpose() * d.rotation_by_gyro_bias - RightJacobian(0.5 * turn) * (0.5 * dt);
  const Matrix3d gain_by_gyro = -turned_force * half_by_bias * dt;
  const Matrix3d gain_by_accel = -half * dt;

  Matrix9d transition = Matrix9d::Identity();
  transition.block<3, 3>(0, 0) = step.transpose();
  transition.block<3, 3>(3, 0) = -d.rotation * Skew(force) * dt;
  transition.block<3, 3>(6, 0) = 0.5 * dt * transition.block<3, 3>(3, 0);
  transition.block<3, 3>(6, 3) = dt * Matrix3d::Identity();
  sum.covariance = (transition * sum.covariance * transition.transpose()).eval();
  const double accel = noise.accel_white * noise.accel_white;
  sum.covariance.diagonal().head<3>().array() += noise.gyro_white * noise.gyro_white * dt;
  sum.covariance.diagonal().segment<3>(3).array() += accel * dt;
  sum.covariance.diagonal().tail<3>().array() += accel * dt * dt * dt / 3.0;
  for (int k = 0; k < 3; ++k) {
    sum.covariance(3 + k, 6 + k) += 0.5 * accel * dt * dt;
    sum.covariance(6 + k, 3 + k) += 0.5 * accel * dt * dt;
  }

  const Vector3d gain = half * force * dt;
  d.position += dt * d.velocity + 0.5 * dt * gain;
  d.velocity += gain;
  d.position_by_gyro_bias += dt * d.velocity_by_gyro_bias + 0.5 * dt * gain_by_gyro;
  d.position_by_accel_bias += dt * d.velocity_by_accel_bias + 0.5 * dt * gain_by_accel;
  d.velocity_by_gyro_bias += gain_by_gyro;
  d.velocity_by_accel_bias += gain_by_accel;
  d.rotation_by_gyro_bias = step.transpose() * d.rotation_by_gyro_bias - right;
  d.rotation = d.rotation * step;
  d.duration_s += dt;
}

}  // namespace

Matrix3d ImuDelta::CorrectedRotation(const Vector3d& gyro_bias_now) const {
  return rotation * ExpSo3(rotation_by_gyro_bias * (gyro_bias_now - gyro_bias));
}
Vector3d ImuDelta::CorrectedVelocity(const KnotState& s) const {
  return velocity + velocity_by_gyro_bias * (s.gyro_bias_radps - gyro_bias) +
         velocity_by_accel_bias * (s.accel_bias_mps2 - accel_bias);
}
Vector3d ImuDelta::CorrectedPosition(const KnotState& s) const {
  return position + position_by_gyro_bias * (s.gyro_bias_radps - gyro_bias) +
         position_by_accel_bias * (s.accel_bias_mps2 - accel_bias);
}

KnotState ImuDelta::Predict(const KnotState& start, double gravity_mps2) const {
  const Vector3d gravity(0.0, 0.0, -gravity_mps2);
  KnotState end = start;
  end.enu_from_body =
      (start.enu_from_body * Eigen::Quaterniond(CorrectedRotation(start.gyro_bias_radps))).normalized();
  end.velocity_in_enu_mps += gravity * duration_s + start.enu_from_body * CorrectedVelocity(start);
  end.position_in_enu_m += start.velocity_in_enu_mps * duration_s + 0.5 * duration_s * duration_s * gravity +
                           start.enu_from_body * CorrectedPosition(start);
  return end;
}

std::optional<Preintegration> Preintegrate(const std::vector<flight::ImuSample>& samples, double begin_s,
                                           double end_s, const std::vector<double>& cuts,
                                           const Vector3d& gyro_bias, const Vector3d& accel_bias,
                                           const ImuNoise& noise) {
  if (samples.size() < 2 || !(end_s > begin_s)) return std::nullopt;
  const auto later = [](double t, const flight::ImuSample& s) { return t < s.t_s; };
  auto next = static_cast<std::size_t>(std::upper_bound(samples.begin(), samples.end(), begin_s, later) -
                                       samples.begin());
  constexpr double kMaxGapS = 0.2;  // a longer hole ends the inertial chain
  // Half a usual step may be missing at either end of the log.
  constexpr double kReachS = 0.5 * kMaxGapS;
  if (begin_s < samples.front().t_s - kReachS || end_s > samples.back().t_s + kReachS) return std::nullopt;
  Preintegration sum;
  sum.delta.gyro_bias = gyro_bias;
  sum.delta.accel_bias = accel_bias;
  sum.at_cuts.reserve(cuts.size());
  std::size_t cut = 0;
  double t = begin_s;
  ImuReading before = ReadingAt(samples, next, t);
  const auto keep_cuts = [&] {
    for (; cut < cuts.size() && cuts[cut] <= t; ++cut) {
      sum.delta.end_rate_radps = before.rate;
      sum.delta.end_force_mps2 = before.force;
      sum.at_cuts.push_back(sum.delta);
    }
  };
  keep_cuts();
  while (t < end_s) {
    double stop = end_s;
    bool at_sample = false;
    if (next < samples.size() && samples[next].t_s <= stop) {
      stop = samples[next].t_s;
      at_sample = true;
    }
    if (cut < cuts.size() && cuts[cut] < stop) {
      stop = cuts[cut];
      at_sample = false;
    }
    if (next > 0 && next < samples.size() && samples[next].t_s - samples[next - 1].t_s > kMaxGapS) {
      return std::nullopt;
    }
    const ImuReading after = ReadingAt(samples, next, stop);
    if (stop > t) {
      Step(0.5 * (before.rate + after.rate), 0.5 * (before.force + after.force), stop - t, noise, sum);
    }
    before = after;
    t = stop;
    if (at_sample) ++next;
    keep_cuts();
  }
  keep_cuts();
  sum.delta.end_rate_radps = before.rate;
  sum.delta.end_force_mps2 = before.force;
  return sum;
}

}  // namespace skyquilt::poses
