// What the sensors of an AnalyticFlight record, with honest errors: correlated GNSS and attitude errors,
// biased and noisy inertial samples that are means over their interval, drifting barometer. Units as in
// core/poses/smoother/smoother.h.
#pragma once

#include "core/poses/smoother/smoother.h"
#include "tests/bench/poses/analytic_flight.h"

namespace skyquilt::bench {

struct SensorErrors {
  double imu_rate_hz = 100.0;
  double gyro_white = 7.0e-5;    // rad/s/sqrt(Hz), ICM-20602 class
  double accel_white = 2.0e-3;   // m/s2/sqrt(Hz), the same in flight
  double gyro_turn_on = 0.0052;  // rad/s: 0.3 deg/s
  double accel_turn_on = 0.04;   // m/s2: 4 mg
  double gyro_walk = 2.0e-5;
  double accel_walk = 1.0e-3;
  double fix_rate_hz = 5.0;  // GNSS, attitude, barometer, range
  Eigen::Vector3d gnss_white{0.15, 0.15, 0.24};
  Eigen::Vector3d gnss_slow{1.0, 1.0, 1.8};
  double gnss_slow_s = 120.0;
  Eigen::Vector3d gnss_velocity{0.08, 0.08, 0.12};
  double attitude_white = 0.0017;
  Eigen::Vector3d attitude_slow{0.01047, 0.01047, 0.0436};
  double attitude_slow_s = 40.0;
  double baro_white = 0.15;
  double baro_walk = 0.0577;
  double baro_first = 0.1;
};

struct RecordedSensors {
  std::vector<flight::ImuSample> imu;
  std::vector<poses::PositionFix> positions, photo_positions;
  std::vector<poses::VelocityFix> velocities, photo_velocities;
  std::vector<poses::AttitudeFix> attitudes, photo_attitudes;
  std::vector<poses::HeightFix> heights, photo_heights;
  std::vector<poses::RangeFix> ranges;
};

RecordedSensors RecordSensors(const AnalyticFlight& flight, const SensorErrors& errors, std::uint64_t seed);

}  // namespace skyquilt::bench
