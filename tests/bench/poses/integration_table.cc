#include <fmt/core.h>

#include <cmath>
#include <random>

#include "core/geo/rigid3.h"
#include "tests/bench/poses/strapdown.h"
#include "tests/bench/poses/tables.h"

namespace skyquilt::bench {
namespace {

using Eigen::Vector3d;

constexpr double kTwoPi = 6.283185307179586;
constexpr double kGravity = poses::kStandardGravityMps2;

// Known motion up to 6 Hz along each axis, with a nose that swings: position, and from it force and rates, by
// formula.
class Shaking {
 public:
  explicit Shaking(std::uint64_t seed) : random_(seed) {
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    for (const double hz : {0.2, 0.7, 1.9, 3.7, 6.0}) {
      Wave wave;
      wave.rate = kTwoPi * hz;
      // Acceleration falls with the square of the frequency, as that of an airframe does.
      wave.amplitude = Vector3d(2.0, 1.5, 1.0) / (1.0 + 4.0 * hz * hz) / (wave.rate * wave.rate);
      wave.phase = kTwoPi * Vector3d(uniform(random_), uniform(random_), uniform(random_));
      wave.swing = 0.1 / (1.0 + hz * hz);
      waves_.push_back(wave);
    }
  }
  poses::StrapdownState At(double t) const {
    poses::StrapdownState s;
    s.t_s = t;
    double yaw = 0.0;
    for (const Wave& w : waves_) {
      const Eigen::Array3d angle = w.rate * t + w.phase.array();
      s.position_in_enu_m += (w.amplitude.array() * angle.sin()).matrix();
      s.velocity_in_enu_mps += (w.rate * w.amplitude.array() * angle.cos()).matrix();
      yaw += w.swing * std::sin(w.rate * t);
    }
    s.enu_from_body =
        Eigen::AngleAxisd(-yaw, Vector3d::UnitZ()) * Eigen::AngleAxisd(0.5 * kTwoPi, Vector3d::UnitX());
    return s;
  }
  flight::ImuSample Sample(double t, double vibration_mps2) const {
    Vector3d acceleration = Vector3d::Zero();
    double yaw_rate = 0.0;
    for (const Wave& w : waves_) {
      const Eigen::Array3d angle = w.rate * t + w.phase.array();
      acceleration -= (w.rate * w.rate * w.amplitude.array() * angle.sin()).matrix();
      yaw_rate += w.swing * w.rate * std::cos(w.rate * t);
    }
    flight::ImuSample sample;
    sample.t_s = t;
    // A clockwise turn seen from above is positive about the down axis.
    sample.angular_rate_radps = Vector3d(0.0, 0.0, yaw_rate);
    sample.specific_force_mps2 =
        At(t).enu_from_body.conjugate() * (acceleration + Vector3d(0.0, 0.0, kGravity));
    // A line near 120 Hz, sampled as a logger without a filter does; its displacement is micrometres.
    sample.specific_force_mps2.x() += vibration_mps2 * std::sin(kTwoPi * 120.007 * t + 0.3);
    return sample;
  }

 private:
  struct Wave {
    double rate;
    Vector3d amplitude;
    Vector3d phase;
    double swing;
  };
  std::mt19937_64 random_;
  std::vector<Wave> waves_;
};

std::vector<flight::ImuSample> Samples(const Shaking& motion, double hz, double seconds, double vibration) {
  std::vector<flight::ImuSample> samples;
  for (int k = 0; k <= static_cast<int>(std::lround(hz * seconds)); ++k) {
    samples.push_back(motion.Sample(k / hz, vibration));
  }
  return samples;
}

Vector3d End(const std::vector<flight::ImuSample>& samples, const Shaking& motion,
             poses::IntegrationRule rule) {
  poses::StrapdownOptions options;
  options.rule = rule;
  const auto path = poses::IntegrateStrapdown(samples, motion.At(samples.front().t_s), options);
  return path->back().position_in_enu_m;
}

// Rectangles, each sample held to the next: what the table starts from.
Vector3d EulerEnd(const std::vector<flight::ImuSample>& samples, const Shaking& motion) {
  poses::StrapdownState s = motion.At(samples.front().t_s);
  for (std::size_t k = 0; k + 1 < samples.size(); ++k) {
    const double dt = samples[k + 1].t_s - samples[k].t_s;
    const Vector3d a = s.enu_from_body * samples[k].specific_force_mps2 - Vector3d(0.0, 0.0, kGravity);
    s.position_in_enu_m += dt * s.velocity_in_enu_mps;
    s.velocity_in_enu_mps += dt * a;
    s.enu_from_body =
        (s.enu_from_body * geo::RotationFromVector(dt * samples[k].angular_rate_radps)).normalized();
  }
  return s.position_in_enu_m;
}

void PrintExact(double hz, double vibration, int seeds) {
  double euler = 0.0, trapezoid = 0.0, simpson = 0.0;
  for (int seed = 1; seed <= seeds; ++seed) {
    const Shaking motion(static_cast<std::uint64_t>(seed));
    const auto samples = Samples(motion, hz, 60.0, vibration);
    const Vector3d truth = motion.At(samples.back().t_s).position_in_enu_m;
    euler += (EulerEnd(samples, motion) - truth).squaredNorm() / seeds;
    trapezoid += (End(samples, motion, poses::IntegrationRule::kTrapezoid) - truth).squaredNorm() / seeds;
    simpson += (End(samples, motion, poses::IntegrationRule::kSimpson) - truth).squaredNorm() / seeds;
  }
  fmt::print("{:>4.0f} Hz, {:<32} {:>12.3g} {:>12.3g} {:>12.3g}\n", hz,
             vibration > 0.0 ? "3 m/s2 at 120 Hz, aliased" : "exact samples", std::sqrt(euler),
             std::sqrt(trapezoid), std::sqrt(simpson));
}

void PrintNoisy(double seconds, int seeds) {
  double trapezoid = 0.0, difference = 0.0;
  for (int seed = 1; seed <= seeds; ++seed) {
    const Shaking motion(static_cast<std::uint64_t>(seed));
    std::mt19937_64 random(static_cast<std::uint64_t>(seed));
    std::normal_distribution<double> normal;
    auto samples = Samples(motion, 100.0, seconds, 0.0);
    const double direction = kTwoPi * normal(random);
    const Vector3d bias = 0.049 * Vector3d(std::cos(direction), std::sin(direction), 0.0);  // 5 mg
    for (flight::ImuSample& s : samples) {
      // 0.005 deg/s/sqrt(Hz) and 400 ug/sqrt(Hz) at 100 Hz.
      s.angular_rate_radps += 8.7e-4 * Vector3d(normal(random), normal(random), normal(random));
      s.specific_force_mps2 += bias + 0.039 * Vector3d(normal(random), normal(random), normal(random));
    }
    const Vector3d truth = motion.At(samples.back().t_s).position_in_enu_m;
    const Vector3d a = End(samples, motion, poses::IntegrationRule::kTrapezoid);
    const Vector3d b = End(samples, motion, poses::IntegrationRule::kSimpson);
    trapezoid += (a - truth).head<2>().squaredNorm() / seeds;
    difference += (a - b).head<2>().squaredNorm() / seeds;
  }
  fmt::print(
      "{:>4.0f} s, MPU-6000 noise + 5 mg bias: trapezoid {:.3g} m, Simpson differs from it by {:.2g} m\n",
      seconds, std::sqrt(trapezoid), std::sqrt(difference));
}

}  // namespace

void PrintIntegrationTable(int seeds) {
  fmt::print(
      "Double integration over 60 s of motion up to 6 Hz: error of the end point, m (RMS of {} runs)\n",
      seeds);
  fmt::print("{:<42} {:>12} {:>12} {:>12}\n", "", "Euler", "trapezoid", "Simpson");
  for (const double hz : {25.0, 50.0, 100.0, 200.0}) PrintExact(hz, 0.0, seeds);
  for (const double hz : {25.0, 50.0, 100.0, 200.0}) PrintExact(hz, 3.0, seeds);
  fmt::print(
      "Reference: 25 Hz 1.5 / 0.016 / 0.0013; 50 Hz 0.74 / 0.004 / 7e-5; 200 Hz 0.19 / 2.5e-4 / 3e-7; 25 Hz "
      "with "
      "vibration 3.7 / 6.6 / 7.2\n");
  for (const double seconds : {10.0, 60.0, 300.0}) PrintNoisy(seconds, seeds);
  fmt::print("Reference: 2.4 / 85 / 2137 m, differing by 0.02 / 0.23 / 3.9 m\n\n");
}

}  // namespace skyquilt::bench
