// Strapdown: dead reckoning from body rates and specific force, gravity and rotation done right: the body's
// specific force is rotated to enu sample by sample and gravity is added back before it is summed twice.
// Frames: `body` (x forward, y right, z down) and `enu`; metres, seconds, radians. True sample times are
// used, never a nominal rate. Pure functions; any thread. Fails (Result) on samples that are out of order or
// not finite. Trapezoid is the default. Simpson is there to be compared: it needs pairs of equal steps, and
// it weights alternate samples 4:2, which makes aliased vibration worse. Neither removes drift; the smoother
// does. Source: P. D. Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation (2013),
// chapter 5; replaces the "detrended" double integration of Iz and Unel, equations (1)-(3).
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "core/base/result.h"
#include "core/flight/logs/flight_log.h"
#include "core/poses/smoother/preintegration.h"

namespace skyquilt::poses {

enum class IntegrationRule { kTrapezoid, kSimpson };

struct StrapdownState {
  double t_s = 0.0;
  Eigen::Quaterniond enu_from_body = Eigen::Quaterniond::Identity();
  Eigen::Vector3d velocity_in_enu_mps = Eigen::Vector3d::Zero();
  Eigen::Vector3d position_in_enu_m = Eigen::Vector3d::Zero();
};

struct StrapdownOptions {
  IntegrationRule rule = IntegrationRule::kTrapezoid;
  double gravity_mps2 = kStandardGravityMps2;
  Eigen::Vector3d gyro_bias_radps = Eigen::Vector3d::Zero();  // taken off the rates
  Eigen::Vector3d accel_bias_mps2 = Eigen::Vector3d::Zero();  // taken off the specific force
};

// One state a sample (Simpson: one every second sample, and a trapezoid step where the two steps of a pair
// differ by more than 1 %). `start` is the state at the first sample; its t_s is replaced by the sample's.
Result<std::vector<StrapdownState>> IntegrateStrapdown(const std::vector<flight::ImuSample>& samples,
                                                       const StrapdownState& start,
                                                       const StrapdownOptions& options = {});

// The same with the rotation given at each sample (an autopilot's attitude): only the force is integrated.
Result<std::vector<StrapdownState>> IntegrateStrapdownWithAttitude(
    const std::vector<flight::ImuSample>& samples, const std::vector<Eigen::Quaterniond>& enu_from_body,
    const StrapdownState& start, const StrapdownOptions& options = {});

}  // namespace skyquilt::poses
