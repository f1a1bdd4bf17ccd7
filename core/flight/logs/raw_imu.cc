#include "core/flight/logs/raw_imu.h"

namespace skyquilt::flight {
namespace {

constexpr std::size_t kMaxWaiting = 4096;
constexpr double kLongestGapS = 0.05;  // accelerometer samples further apart are not joined

}  // namespace

void RawImuPairing::AddGyro(double t_s, const Eigen::Vector3d& angular_rate_radps) {
  if (gyro_.size() == kMaxWaiting) gyro_.pop_front();
  gyro_.push_back({t_s, angular_rate_radps});
}

void RawImuPairing::AddAccel(double t_s, const Eigen::Vector3d& specific_force_mps2) {
  while (accel_ && !gyro_.empty() && gyro_.front().t_s <= t_s) {
    const Reading gyro = gyro_.front();
    gyro_.pop_front();
    const double gap = t_s - accel_->t_s;
    if (gyro.t_s < accel_->t_s || gap > kLongestGapS) continue;
    const double share = gap > 0.0 ? (gyro.t_s - accel_->t_s) / gap : 1.0;
    emit_(ImuSample{gyro.t_s, gyro.value, accel_->value + share * (specific_force_mps2 - accel_->value)});
  }
  accel_ = Reading{t_s, specific_force_mps2};
}

}  // namespace skyquilt::flight
