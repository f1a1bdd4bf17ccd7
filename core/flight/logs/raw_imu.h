// RawImuPairing: recorders that log gyroscope and accelerometer apart, each at its own times, give one IMU
// series: at every gyroscope sample, with the accelerometer interpolated between its neighbours. One thread.
#pragma once

#include <deque>
#include <functional>
#include <optional>

#include "core/flight/logs/flight_log.h"

namespace skyquilt::flight {

class RawImuPairing {
 public:
  explicit RawImuPairing(std::function<void(const ImuSample&)> emit) : emit_(std::move(emit)) {}

  void AddGyro(double t_s, const Eigen::Vector3d& angular_rate_radps);
  void AddAccel(double t_s, const Eigen::Vector3d& specific_force_mps2);

 private:
  struct Reading {
    double t_s;
    Eigen::Vector3d value;
  };
  std::function<void(const ImuSample&)> emit_;
  std::deque<Reading> gyro_;  // later than the last accelerometer sample; at most 4096 wait
  std::optional<Reading> accel_;
};

}  // namespace skyquilt::flight
