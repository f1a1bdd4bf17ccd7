#include "core/simulate/sensors/flight_path.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/geo/lat_lon.h"
#include "core/geo/rigid3.h"
#include "core/simulate/world/random.h"

namespace skyquilt::simulate {
namespace {

constexpr double kThrustLagS = 0.12;       // how fast the airframe follows the thrust asked for
constexpr double kPositionGainPerS = 0.5;  // the autopilot pulls back to the reference
constexpr double kSettleS = 4.0;           // after the last waypoint, before the motors stop
constexpr double kBlendS = 1.0;            // motion fades in and out on the ground

// The moving reference: along the polyline at each way's speed, standing at the corners.
class Reference {
 public:
  explicit Reference(const PathOptions& options) : options_(options), yaw_(options.start_yaw_rad) {}

  bool IsDone() const { return next_ >= options_.waypoints.size(); }
  const Eigen::Vector3d& point() const { return point_; }
  const Eigen::Vector3d& velocity() const { return velocity_; }
  double yaw() const { return yaw_; }

  // True when a waypoint was reached in this step.
  bool Step(double dt_s) {
    velocity_.setZero();
    if (IsDone()) return false;
    const Waypoint& way = options_.waypoints[next_];
    const Eigen::Vector3d rest = way.point_in_enu - point_;
    if (way.sets_yaw && rest.head<2>().norm() > 1.0) {
      const double wanted = std::atan2(rest.x(), rest.y());
      const double off = geo::WrapRad(wanted - yaw_);
      const double most = options_.yaw_rate_radps * dt_s;
      yaw_ += std::clamp(off, -most, most);
      if (std::abs(off) > 0.05) return false;  // turns on the spot first
    }
    if (stay_s_ > 0.0) {
      stay_s_ -= dt_s;
      return false;
    }
    const double step_m = way.speed_mps * dt_s;
    if (rest.norm() <= step_m) {
      point_ = way.point_in_enu;
      stay_s_ = way.stay_s;
      ++next_;
      return true;
    }
    velocity_ = way.speed_mps * rest.normalized();
    point_ += dt_s * velocity_;
    return false;
  }

 private:
  const PathOptions& options_;
  std::size_t next_ = 0;
  Eigen::Vector3d point_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_ = Eigen::Vector3d::Zero();
  double yaw_;
  double stay_s_ = 0.0;
};

// Body axes from the direction of thrust (the body's up) and the heading.
Eigen::Quaterniond AttitudeOf(const Eigen::Vector3d& thrust, double yaw_rad) {
  const Eigen::Vector3d down = -thrust.normalized();
  const Eigen::Vector3d ahead(std::sin(yaw_rad), std::cos(yaw_rad), 0.0);
  const Eigen::Vector3d right = down.cross(ahead).normalized();
  Eigen::Matrix3d enu_from_body;
  enu_from_body.col(0) = right.cross(down);
  enu_from_body.col(1) = right;
  enu_from_body.col(2) = down;
  return Eigen::Quaterniond(enu_from_body).normalized();
}

}  // namespace

FlightPath FlyPath(const PathOptions& options) {
  SKYQUILT_CHECK(!options.waypoints.empty(), "a flight path needs a waypoint");
  RandomStream random(options.seed, 401);
  GaussMarkov gust_east(options.gust_mps, options.gust_correlation_s, random);
  GaussMarkov gust_north(options.gust_mps, options.gust_correlation_s, random);
  GaussMarkov gust_up(0.5 * options.gust_mps, options.gust_correlation_s, random);
  Reference reference(options);
  const double h = kPathStepS;
  PathState state;
  double yaw = options.start_yaw_rad;
  double yaw_rate = 0.0;
  const Eigen::Vector3d gravity_up(0.0, 0.0, options.gravity_mps2);
  Eigen::Vector3d thrust = gravity_up;
  Eigen::Vector3d first_pass = Eigen::Vector3d::Zero();
  state.enu_from_body = AttitudeOf(thrust, yaw);

  std::vector<PathState> states;
  std::vector<double> arrivals_s;
  const auto still_steps = static_cast<std::size_t>(std::lround(options.still_before_s / h));
  states.assign(still_steps + 1, state);
  double moving_s = 0.0;
  double settling_s = 0.0;
  while (settling_s < kSettleS) {
    if (reference.Step(h)) arrivals_s.push_back(h * static_cast<double>(states.size()));
    if (reference.IsDone()) settling_s += h;
    moving_s += h;
    const double blend = std::clamp(std::min(moving_s, kSettleS - settling_s) / kBlendS, 0.0, 1.0);
    const Eigen::Vector3d gust{gust_east.Step(h, random), gust_north.Step(h, random),
                               gust_up.Step(h, random)};
    const Eigen::Vector3d command =
        reference.velocity() + blend * gust + kPositionGainPerS * (reference.point() - state.point_in_enu);
    first_pass += h / options.low_pass_s * (command - first_pass);
    Eigen::Vector3d acceleration = (first_pass - state.velocity_in_enu_mps) / options.low_pass_s;
    const Eigen::Vector3d wanted_thrust =
        acceleration + gravity_up + options.drag_per_s * state.velocity_in_enu_mps;
    thrust += h / kThrustLagS * (wanted_thrust - thrust);
    const double wanted_rate = std::clamp(2.5 * geo::WrapRad(reference.yaw() - yaw), -1.2, 1.2);
    yaw_rate += h / 0.25 * (wanted_rate - yaw_rate);
    yaw += h * yaw_rate;
    PathState next;
    next.point_in_enu = state.point_in_enu + h * state.velocity_in_enu_mps + 0.5 * h * h * acceleration;
    next.velocity_in_enu_mps = state.velocity_in_enu_mps + h * acceleration;
    next.enu_from_body = AttitudeOf(thrust, yaw);
    states.push_back(next);
    state = next;
  }
  // Touch-down: the last motion, millimetres a second, is braked away within half a second; then stillness.
  constexpr int kBrakeSteps = 250;
  const Eigen::Vector3d brake = -state.velocity_in_enu_mps / (kBrakeSteps * h);
  const Eigen::Quaterniond level = AttitudeOf(gravity_up, yaw);
  const Eigen::Quaterniond lean = state.enu_from_body;
  for (int i = 1; i <= kBrakeSteps; ++i) {
    PathState next = state;
    next.point_in_enu += h * state.velocity_in_enu_mps + 0.5 * h * h * brake;
    next.velocity_in_enu_mps =
        i == kBrakeSteps ? Eigen::Vector3d::Zero() : Eigen::Vector3d(state.velocity_in_enu_mps + h * brake);
    next.enu_from_body = lean.slerp(static_cast<double>(i) / kBrakeSteps, level);
    states.push_back(next);
    state = next;
  }
  states.insert(states.end(), static_cast<std::size_t>(std::lround(options.still_after_s / h)), state);
  return FlightPath(std::move(states), std::move(arrivals_s), options.gravity_mps2);
}

PathState FlightPath::At(double t_s) const {
  const double step = std::clamp(t_s, 0.0, EndS()) / kPathStepS;
  const auto i = std::min(static_cast<std::size_t>(step), states_.size() - 2);
  const double share = step - static_cast<double>(i);
  const PathState& a = states_[i];
  const PathState& b = states_[i + 1];
  const Eigen::Vector3d acceleration = (b.velocity_in_enu_mps - a.velocity_in_enu_mps) / kPathStepS;
  const double dt_s = share * kPathStepS;
  PathState state;
  state.point_in_enu = a.point_in_enu + dt_s * a.velocity_in_enu_mps + 0.5 * dt_s * dt_s * acceleration;
  state.velocity_in_enu_mps = a.velocity_in_enu_mps + dt_s * acceleration;
  state.enu_from_body = a.enu_from_body.slerp(share, b.enu_from_body);
  return state;
}

void FlightPath::MeanInertial(double begin_s, double end_s, Eigen::Vector3d& rate_radps,
                              Eigen::Vector3d& force_mps2) const {
  // Cut at the steps' borders: inside a part acceleration and rate are constant.
  const Eigen::Vector3d gravity_up(0.0, 0.0, gravity_mps2_);
  Eigen::Vector3d turned = Eigen::Vector3d::Zero();
  Eigen::Vector3d pushed = Eigen::Vector3d::Zero();
  double from_s = begin_s;
  PathState from = At(from_s);
  while (from_s < end_s - 1e-12) {
    const double border_s = (std::floor(from_s / kPathStepS + 1e-7) + 1.0) * kPathStepS;
    const double to_s = std::min(border_s, end_s);
    const PathState to = At(to_s);
    turned += geo::VectorFromRotation(from.enu_from_body.conjugate() * to.enu_from_body);
    const Eigen::Quaterniond middle = from.enu_from_body.slerp(0.5, to.enu_from_body);
    pushed += middle.conjugate() *
              (to.velocity_in_enu_mps - from.velocity_in_enu_mps + (to_s - from_s) * gravity_up);
    from_s = to_s;
    from = to;
  }
  rate_radps = turned / (end_s - begin_s);
  force_mps2 = pushed / (end_s - begin_s);
}

double GravityMps2(double lat_deg, double height_ellipsoid_m) {
  // WGS84 normal gravity series (Moritz, Geodetic Reference System 1980) and the free-air gradient.
  const double s = std::sin(geo::DegToRad(lat_deg));
  const double s2 = std::sin(2.0 * geo::DegToRad(lat_deg));
  return 9.7803267715 * (1.0 + 0.0053024 * s * s - 0.0000058 * s2 * s2) - 3.086e-6 * height_ellipsoid_m;
}

Eigen::Quaterniond NedFromBody(const Eigen::Quaterniond& enu_from_body) {
  Eigen::Matrix3d ned_from_enu;
  ned_from_enu << 0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, -1.0;
  return Eigen::Quaterniond(Eigen::Matrix3d(ned_from_enu * enu_from_body.toRotationMatrix())).normalized();
}

Eigen::Vector3d NedYawPitchRoll(const Eigen::Quaterniond& enu_from_body) {
  const Eigen::Matrix3d m = NedFromBody(enu_from_body).toRotationMatrix();
  return {std::atan2(m(1, 0), m(0, 0)), std::asin(std::clamp(-m(2, 0), -1.0, 1.0)),
          std::atan2(m(2, 1), m(2, 2))};
}

}  // namespace skyquilt::simulate
