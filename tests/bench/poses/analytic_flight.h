// AnalyticFlight: a multirotor survey whose position is a formula in time, so that its velocity,
// acceleration, attitude and rates are exact without integrating anything: nothing here is shared with the
// estimator. Frames `enu` and `body`; metres, seconds, radians. A value; any thread.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

namespace skyquilt::bench {

struct FlightPlan {
  double still_s = 9.0;  // on the ground at the start, truly still
  double height_m = 60.0;
  double climb_mps = 2.0;
  int legs = 5;
  double leg_m = 250.0;
  double speed_mps = 8.0;
  double leg_spacing_m = 50.0;
  double heading_rad = 0.6;  // of the first leg
  double photo_interval_s = 2.0;
  double gust_mps = 0.3;
  double crab_rad = 0.05;  // slow wander of the nose about the course
  bool is_gimbal = false;  // the body described is a gimbal's that stays level and turns with the nose
};

struct FlightTruth {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();
  Eigen::Quaterniond enu_from_body = Eigen::Quaterniond::Identity();
};

class AnalyticFlight {
 public:
  AnalyticFlight(const FlightPlan& plan, std::uint64_t seed);

  double duration_s() const { return duration_s_; }
  double landed_s() const { return landed_s_; }  // still from here to the end
  const std::vector<double>& photo_times_s() const { return photo_times_s_; }
  FlightTruth At(double t_s) const;
  Eigen::Vector3d BodyRate(double t_s) const;
  Eigen::Vector3d SpecificForce(double t_s) const;  // in body

 private:
  struct VelocityStep {
    double begin_s;
    double ramp_s;
    Eigen::Vector3d change;
  };
  struct YawStep {
    double begin_s;
    double ramp_s;
    double change;
  };
  struct Wave {
    double rate;  // rad/s
    Eigen::Vector3d amplitude;
    Eigen::Vector3d phase;
  };
  double Yaw(double t_s) const;
  // 0 on the ground, 1 in the air, with two derivatives.
  Eigen::Vector3d Airborne(double t_s) const;

  std::vector<VelocityStep> steps_;
  std::vector<YawStep> yaw_steps_;
  std::vector<Wave> gusts_;
  std::vector<Wave> crab_;
  std::vector<double> photo_times_s_;
  bool is_gimbal_ = false;
  double first_yaw_ = 0.0;
  double takeoff_s_ = 0.0;
  double landed_s_ = 0.0;
  double duration_s_ = 0.0;
};

}  // namespace skyquilt::bench
