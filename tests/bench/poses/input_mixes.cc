#include "tests/bench/poses/input_mixes.h"

#include <cmath>

namespace skyquilt::bench {
namespace {

bool Uses(InputMix mix, std::initializer_list<InputMix> those) {
  for (const InputMix m : those) {
    if (m == mix) return true;
  }
  return false;
}

bool UsesImu(InputMix mix) {
  return Uses(mix, {InputMix::kImuStart, InputMix::kImuBaroStartEnd, InputMix::kGnssImuBaro,
                    InputMix::kGnssImuAttitudeBaro, InputMix::kRtkImu});
}

bool UsesPhotosAlone(InputMix mix) {
  return Uses(mix, {InputMix::kGnssAttitudeBaro, InputMix::kGnssPoorCompassBaro, InputMix::kRtkAttitude});
}

}  // namespace

FlightPlan PlanOf(InputMix mix) {
  FlightPlan plan;
  plan.is_gimbal = UsesPhotosAlone(mix);
  return plan;
}

SensorErrors ErrorsOf(InputMix mix) {
  SensorErrors e;
  if (!UsesImu(mix)) e.imu_rate_hz = 0.0;
  if (mix == InputMix::kGnssPoorCompassBaro) e.attitude_slow.z() = 0.0873;
  if (Uses(mix, {InputMix::kRtkAttitude, InputMix::kRtkImu})) {
    e.gnss_white.setConstant(0.008);
    e.gnss_slow = Eigen::Vector3d(0.01, 0.01, 0.02);
  }
  return e;
}

poses::SmootherInput InputOf(InputMix mix, const AnalyticFlight& flight, const RecordedSensors& sensors) {
  const SensorErrors errors = ErrorsOf(mix);
  poses::SmootherInput in;
  in.photo_times_s = flight.photo_times_s();
  in.options.gnss_bias_sigma_m = errors.gnss_slow;
  in.options.attitude_bias_sigma_rad = errors.attitude_slow;
  in.options.imu.accel_white = errors.accel_white;
  const bool only_photos = UsesPhotosAlone(mix);
  if (UsesImu(mix)) in.imu = sensors.imu;
  const bool has_start = Uses(mix, {InputMix::kImuStart, InputMix::kImuBaroStartEnd});
  if (has_start) {
    poses::Marker marker;
    marker.t_s = 0.0;
    const FlightTruth start = flight.At(marker.t_s);
    marker.position_in_enu_m = start.position;
    const Eigen::Vector3d nose = start.enu_from_body * Eigen::Vector3d::UnitX();
    // The yaw of the marker is itself read with an error of 2 degrees: a draw that differs from flight to
    // flight.
    const double draw = std::sin(1e4 * (sensors.heights.front().z_in_enu_m + 1.0)) * std::sqrt(2.0);
    marker.yaw_rad = std::atan2(nose.x(), nose.y()) + 0.0349 * draw;
    in.markers.push_back(marker);
    in.still.push_back({0.0, 8.9});
  } else {
    in.positions = only_photos ? sensors.photo_positions : sensors.positions;
    in.velocities = only_photos ? sensors.photo_velocities : sensors.velocities;
  }
  if (mix == InputMix::kImuBaroStartEnd) {
    poses::Marker marker;
    marker.t_s = flight.duration_s() - 1.0;
    marker.position_in_enu_m = flight.At(marker.t_s).position;
    in.markers.push_back(marker);
    in.still.push_back({flight.landed_s() + 0.2, flight.duration_s() - 0.5});
  }
  if (Uses(mix, {InputMix::kGnssAttitudeBaro, InputMix::kGnssPoorCompassBaro, InputMix::kGnssImuAttitudeBaro,
                 InputMix::kRtkAttitude})) {
    in.attitudes = only_photos ? sensors.photo_attitudes : sensors.attitudes;
  }
  if (!Uses(mix, {InputMix::kImuStart, InputMix::kGnssCourse, InputMix::kRtkAttitude, InputMix::kRtkImu})) {
    in.heights = only_photos ? sensors.photo_heights : sensors.heights;
    // The first height of a photo is a while after take-off: the barometer has drifted since.
    if (only_photos) in.options.baro_bias_first_sigma_m = std::hypot(0.1, errors.baro_walk * std::sqrt(40.0));
  }
  if (mix == InputMix::kGnssCourse) {
    in.options.assume_level = true;
    in.options.yaw_from_course = true;
    in.options.attitude_bias_sigma_rad =
        Eigen::Vector3d(0.19, 0.19, 0.105);  // 11, 11, 6 deg: the lean of cruise
    in.options.attitude_bias_time_s = 5.0;   // tilt follows every manoeuvre
  }
  return in;
}

}  // namespace skyquilt::bench
