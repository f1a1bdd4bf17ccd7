#include "tests/bench/poses/analytic_flight.h"

#include <cmath>
#include <random>

namespace skyquilt::bench {
namespace {

using Eigen::Vector3d;

constexpr double kGravity = 9.80665;
constexpr double kDragPerS = 0.25;
constexpr double kRampS = 3.5;
constexpr double kTwoPi = 6.283185307179586;

// The smoothest step of degree seven from 0 to 1 over u in [0, 1]: (integral, value, slope, bend).
Eigen::Vector4d SmoothStep(double u) {
  if (u <= 0.0) return Eigen::Vector4d::Zero();
  if (u >= 1.0) return {u - 0.5, 1.0, 0.0, 0.0};
  const double u2 = u * u, u3 = u2 * u, u4 = u2 * u2, v = 1.0 - u;
  return {u4 * u * (7.0 - 14.0 * u + 10.0 * u2 - 2.5 * u3), u4 * (35.0 - 84.0 * u + 70.0 * u2 - 20.0 * u3),
          140.0 * u3 * v * v * v, 420.0 * u2 * v * v * (1.0 - 2.0 * u)};
}

}  // namespace

AnalyticFlight::AnalyticFlight(const FlightPlan& plan, std::uint64_t seed) {
  is_gimbal_ = plan.is_gimbal;
  std::mt19937_64 random(seed * 7919 + 17);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const Vector3d along(std::sin(plan.heading_rad), std::cos(plan.heading_rad), 0.0);
  const Vector3d across(along.y(), -along.x(), 0.0);
  double t = plan.still_s;
  const auto move = [&](const Vector3d& path, double speed) {
    const double time = path.norm() / speed;
    const double ramp = std::min(kRampS, 0.8 * time);
    steps_.push_back({t, ramp, path.normalized() * speed});
    steps_.push_back({t + time, ramp, -path.normalized() * speed});
    t += time + ramp;
  };
  takeoff_s_ = t;
  move(Vector3d(0.0, 0.0, plan.height_m), plan.climb_mps);
  first_yaw_ = plan.heading_rad;
  const double survey_begin = t;
  for (int leg = 0; leg < plan.legs; ++leg) {
    move((leg % 2 == 0 ? 1.0 : -1.0) * plan.leg_m * along, plan.speed_mps);
    if (leg + 1 == plan.legs) break;
    // The nose follows the course: a quarter turn before and after each step to the next leg.
    const double quarter = leg % 2 == 0 ? 0.25 * kTwoPi : -0.25 * kTwoPi;
    yaw_steps_.push_back({t - 3.0, 4.0, quarter});
    move(plan.leg_spacing_m * across, 0.7 * plan.speed_mps);
    yaw_steps_.push_back({t - 3.0, 4.0, quarter});
  }
  for (double photo = survey_begin + 1.0; photo < t - 1.0; photo += plan.photo_interval_s) {
    photo_times_s_.push_back(photo);
  }
  move(Vector3d(0.0, 0.0, -plan.height_m), plan.climb_mps);
  landed_s_ = t;
  duration_s_ = t + 5.0;
  constexpr int kWaves = 6;
  for (int k = 0; k < kWaves; ++k) {
    Wave gust;
    gust.rate = kTwoPi * 0.04 * std::pow(1.6, k) * (0.9 + 0.2 * uniform(random));
    const double speed = plan.gust_mps * std::sqrt(2.0 / kWaves);
    gust.amplitude = Vector3d(speed, speed, 0.5 * speed) / gust.rate;
    gust.phase = kTwoPi * Vector3d(uniform(random), uniform(random), uniform(random));
    gusts_.push_back(gust);
  }
  for (int k = 0; k < 3; ++k) {
    Wave crab;
    crab.rate = kTwoPi / (45.0 + 60.0 * uniform(random));
    crab.amplitude = Vector3d::Constant(plan.crab_rad * std::sqrt(2.0 / 3.0));
    crab.phase = Vector3d::Constant(kTwoPi * uniform(random));
    crab_.push_back(crab);
  }
}

Vector3d AnalyticFlight::Airborne(double t_s) const {
  constexpr double kFade = 5.0;
  const Eigen::Vector4d up = SmoothStep((t_s - takeoff_s_) / kFade);
  const Eigen::Vector4d down = SmoothStep((landed_s_ - t_s) / kFade);
  return {up(1) * down(1), (up(2) * down(1) - up(1) * down(2)) / kFade,
          (up(3) * down(1) - 2.0 * up(2) * down(2) + up(1) * down(3)) / (kFade * kFade)};
}

double AnalyticFlight::Yaw(double t_s) const {
  double yaw = first_yaw_;
  for (const YawStep& s : yaw_steps_) yaw += s.change * SmoothStep((t_s - s.begin_s) / s.ramp_s)(1);
  const double airborne = Airborne(t_s)(0);
  for (const Wave& w : crab_) yaw += airborne * w.amplitude.x() * std::sin(w.rate * t_s + w.phase.x());
  return yaw;
}

FlightTruth AnalyticFlight::At(double t_s) const {
  FlightTruth truth;
  for (const VelocityStep& s : steps_) {
    const Eigen::Vector4d step = SmoothStep((t_s - s.begin_s) / s.ramp_s);
    truth.position += step(0) * s.ramp_s * s.change;
    truth.velocity += step(1) * s.change;
    truth.acceleration += step(2) / s.ramp_s * s.change;
  }
  const Vector3d air = Airborne(t_s);
  for (const Wave& w : gusts_) {
    const Eigen::Array3d angle = w.rate * t_s + w.phase.array();
    const Vector3d x = (w.amplitude.array() * angle.sin()).matrix();
    const Vector3d dx = (w.rate * w.amplitude.array() * angle.cos()).matrix();
    const Vector3d ddx = -w.rate * w.rate * x;
    truth.position += air(0) * x;
    truth.velocity += air(0) * dx + air(1) * x;
    truth.acceleration += air(0) * ddx + 2.0 * air(1) * dx + air(2) * x;
  }
  // Thrust carries weight, acceleration and drag; the body's down axis lies against it.
  Vector3d thrust = truth.acceleration + Vector3d(0.0, 0.0, kGravity) + kDragPerS * truth.velocity;
  if (is_gimbal_) thrust = Vector3d::UnitZ();
  const double yaw = Yaw(t_s);
  Eigen::Matrix3d r;
  r.col(2) = -thrust.normalized();
  r.col(1) = r.col(2).cross(Vector3d(std::sin(yaw), std::cos(yaw), 0.0)).normalized();
  r.col(0) = r.col(1).cross(r.col(2));
  truth.enu_from_body = Eigen::Quaterniond(r).normalized();
  return truth;
}

Vector3d AnalyticFlight::BodyRate(double t_s) const {
  constexpr double kStep = 1e-3;
  const Eigen::AngleAxisd turn(At(t_s - kStep).enu_from_body.conjugate() * At(t_s + kStep).enu_from_body);
  const double angle = std::remainder(turn.angle(), kTwoPi);
  return turn.axis() * (angle / (2.0 * kStep));
}

Vector3d AnalyticFlight::SpecificForce(double t_s) const {
  const FlightTruth truth = At(t_s);
  return truth.enu_from_body.conjugate() * (truth.acceleration + Vector3d(0.0, 0.0, kGravity));
}

}  // namespace skyquilt::bench
