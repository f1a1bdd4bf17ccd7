// FlyPath: the continuous true motion of a multirotor that flies a list of waypoints: commanded velocity
// low-passed twice, gusts, tilt from thrust against drag and gravity, yaw that turns to the new line. Stored
// as steps of constant acceleration and constant turn rate in which position, velocity and attitude agree
// exactly, so that sensors can be generated from differences of the truth without integrating anything.
// Frames: enu, body (x forward, y right, z down). Deterministic in the seed. Immutable; any thread.
// Shares nothing with core/poses: the estimator must not be tested against its own mathematics.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

namespace skyquilt::simulate {

inline constexpr double kPathStepS = 0.002;  // 500 Hz

struct Waypoint {
  Eigen::Vector3d point_in_enu = Eigen::Vector3d::Zero();
  double speed_mps = 8.0;  // on the way to it
  double stay_s = 1.5;     // standing there before going on
  bool sets_yaw = true;    // turns along the way before leaving (false for climb and descent)
};

struct PathOptions {
  std::vector<Waypoint> waypoints;
  double start_yaw_rad = 0.0;
  double still_before_s = 9.0;  // on the ground, truly still
  double still_after_s = 5.0;
  double low_pass_s = 0.7;  // each of the two
  double gust_mps = 0.3;    // 1-sigma of the airframe's velocity wander, each axis
  double gust_correlation_s = 4.0;
  double drag_per_s = 0.25;  // thrust = acceleration - gravity + drag * velocity
  double yaw_rate_radps = 0.7;
  double gravity_mps2 = 9.81;
  std::uint32_t seed = 1;
};

struct PathState {
  Eigen::Vector3d point_in_enu = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_in_enu_mps = Eigen::Vector3d::Zero();
  Eigen::Quaterniond enu_from_body = Eigen::Quaterniond::Identity();
};

class FlightPath {
 public:
  FlightPath(std::vector<PathState> states, std::vector<double> arrivals_s, double gravity_mps2)
      : states_(std::move(states)), arrivals_s_(std::move(arrivals_s)), gravity_mps2_(gravity_mps2) {}

  double EndS() const { return kPathStepS * static_cast<double>(states_.size() - 1); }
  // Exact between the steps (constant acceleration, constant turn rate). t_s is clamped to the flight.
  PathState At(double t_s) const;
  // Means over [begin_s, end_s] of what a rigidly mounted inertial unit feels: body rates and specific force.
  // The rate is the rotation between the ends over the time, for steps a mean in the body's own axes.
  void MeanInertial(double begin_s, double end_s, Eigen::Vector3d& rate_radps,
                    Eigen::Vector3d& force_mps2) const;
  // When the way to waypoint i begins and when the reference reaches it.
  const std::vector<double>& arrivals_s() const { return arrivals_s_; }
  double gravity_mps2() const { return gravity_mps2_; }

 private:
  std::vector<PathState> states_;
  std::vector<double> arrivals_s_;
  double gravity_mps2_;
};

FlightPath FlyPath(const PathOptions& options);

// Normal gravity at a latitude and height: what a simulated accelerometer feels there.
double GravityMps2(double lat_deg, double height_ellipsoid_m);

// Yaw (clockwise from north), pitch, roll of a body in NED, Z-Y-X.
Eigen::Vector3d NedYawPitchRoll(const Eigen::Quaterniond& enu_from_body);
Eigen::Quaterniond NedFromBody(const Eigen::Quaterniond& enu_from_body);

}  // namespace skyquilt::simulate
