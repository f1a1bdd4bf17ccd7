#include "tests/bench/poses/recorded_sensors.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace skyquilt::bench {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

class Noise {
 public:
  explicit Noise(std::uint64_t seed) : random_(seed) {}
  double One() { return normal_(random_); }
  Vector3d Three() { return {One(), One(), One()}; }

 private:
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
};

// A first-order Gauss-Markov error that starts in its steady state.
class SlowError {
 public:
  SlowError(const Vector3d& sigma, double time_s, Noise& noise)
      : sigma_(sigma), time_s_(time_s), noise_(noise), value_(sigma.cwiseProduct(noise.Three())) {}
  Vector3d At(double t_s) {
    const double keep = std::exp(-(t_s - last_s_) / time_s_);
    value_ = keep * value_ + std::sqrt(1.0 - keep * keep) * sigma_.cwiseProduct(noise_.Three());
    last_s_ = t_s;
    return value_;
  }

 private:
  Vector3d sigma_;
  double time_s_;
  Noise& noise_;
  Vector3d value_;
  double last_s_ = 0.0;
};

Quaterniond Small(const Vector3d& angle) {
  const double norm = angle.norm();
  return norm < 1e-12 ? Quaterniond::Identity() : Quaterniond(Eigen::AngleAxisd(norm, angle / norm));
}

// Nose, right and down of a level body with the same heading.
Eigen::Matrix3d Level(const Quaterniond& enu_from_body) {
  const Vector3d nose = enu_from_body * Vector3d::UnitX();
  const double heading = std::atan2(nose.x(), nose.y());
  Eigen::Matrix3d axes;
  axes.col(0) = Vector3d(std::sin(heading), std::cos(heading), 0.0);
  axes.col(1) = Vector3d(std::cos(heading), -std::sin(heading), 0.0);
  axes.col(2) = Vector3d(0.0, 0.0, -1.0);
  return axes;
}

void RecordImu(const AnalyticFlight& flight, const SensorErrors& e, Noise& noise, RecordedSensors& out) {
  const double dt = 1.0 / e.imu_rate_hz;
  const double node = 0.5 / std::sqrt(3.0) * dt;  // the two Gauss points of the interval
  Vector3d gyro_bias = e.gyro_turn_on * noise.Three();
  Vector3d accel_bias = e.accel_turn_on * noise.Three();
  for (double t = 0.0; t <= flight.duration_s(); t += dt) {
    gyro_bias += e.gyro_walk * std::sqrt(dt) * noise.Three();
    accel_bias += e.accel_walk * std::sqrt(dt) * noise.Three();
    flight::ImuSample s;
    s.t_s = t;
    s.angular_rate_radps = 0.5 * (flight.BodyRate(t - node) + flight.BodyRate(t + node)) + gyro_bias +
                           e.gyro_white / std::sqrt(dt) * noise.Three();
    s.specific_force_mps2 = 0.5 * (flight.SpecificForce(t - node) + flight.SpecificForce(t + node)) +
                            accel_bias + e.accel_white / std::sqrt(dt) * noise.Three();
    out.imu.push_back(s);
  }
}

void RecordFixes(const AnalyticFlight& flight, const SensorErrors& e, Noise& noise, RecordedSensors& out) {
  // One time line of fixes and photos together, so that the slow errors are the same for both.
  struct Instant {
    double t_s;
    bool is_photo;
  };
  std::vector<Instant> instants;
  for (double t = 0.013; t < flight.duration_s(); t += 1.0 / e.fix_rate_hz) instants.push_back({t, false});
  for (const double t : flight.photo_times_s()) instants.push_back({t, true});
  std::sort(instants.begin(), instants.end(),
            [](const Instant& a, const Instant& b) { return a.t_s < b.t_s; });
  SlowError gnss(e.gnss_slow, e.gnss_slow_s, noise);
  SlowError attitude(e.attitude_slow, e.attitude_slow_s, noise);
  double baro = e.baro_first * noise.One();
  double last = 0.0;
  for (const Instant& instant : instants) {
    const double t = instant.t_s;
    const FlightTruth truth = flight.At(t);
    baro += e.baro_walk * std::sqrt(t - last) * noise.One();
    last = t;
    const poses::PositionFix p{t, truth.position + gnss.At(t) + e.gnss_white.cwiseProduct(noise.Three()),
                               e.gnss_white};
    const poses::VelocityFix v{t, truth.velocity + e.gnss_velocity.cwiseProduct(noise.Three()),
                               e.gnss_velocity};
    const poses::AttitudeFix a{t,
                               Small(Level(truth.enu_from_body) * attitude.At(t)) * truth.enu_from_body *
                                   Small(e.attitude_white * noise.Three()),
                               e.attitude_white, true};
    const poses::HeightFix h{t, truth.position.z() + baro + e.baro_white * noise.One(), e.baro_white};
    (instant.is_photo ? out.photo_positions : out.positions).push_back(p);
    (instant.is_photo ? out.photo_velocities : out.velocities).push_back(v);
    (instant.is_photo ? out.photo_attitudes : out.attitudes).push_back(a);
    (instant.is_photo ? out.photo_heights : out.heights).push_back(h);
    const double down = -(truth.enu_from_body * Vector3d::UnitZ()).z();
    const double distance = truth.position.z() / down;
    if (!instant.is_photo && distance > 0.3 && distance < 25.0) {
      out.ranges.push_back({t, distance + (0.1 + 0.02 * distance) * noise.One()});
    }
  }
}

}  // namespace

RecordedSensors RecordSensors(const AnalyticFlight& flight, const SensorErrors& errors, std::uint64_t seed) {
  Noise noise(seed * 104729 + 3);
  RecordedSensors out;
  if (errors.imu_rate_hz > 0.0) RecordImu(flight, errors, noise, out);
  RecordFixes(flight, errors, noise, out);
  return out;
}

}  // namespace skyquilt::bench
