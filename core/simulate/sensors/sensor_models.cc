#include "core/simulate/sensors/sensor_models.h"

namespace skyquilt::simulate {

ImuModel IcmClassImu() { return {}; }

ImuModel MpuClassImu() {
  ImuModel imu;
  imu.gyro_white = 8.7e-5;
  imu.accel_white = 3.9e-3;
  imu.gyro_turn_on = 0.0087;
  imu.accel_turn_on = 0.049;
  imu.accel_walk = 1.0e-3;
  return imu;
}

ImuModel PerfectImu(double rate_hz) {
  ImuModel imu;
  imu.rate_hz = rate_hz;
  imu.gyro_white = imu.accel_white = 0.0;
  imu.gyro_turn_on = imu.accel_turn_on = 0.0;
  imu.gyro_walk = imu.accel_walk = 0.0;
  return imu;
}

ImuModel WithDefects(ImuModel imu, double vibration_mps2) {
  imu.scale = 0.005;
  imu.misalignment_rad = 0.0087;
  imu.vibration_mps2 = vibration_mps2;
  imu.gyro_step_radps = 0.00107;  // 2000 deg/s over 16 bits
  imu.accel_step_mps2 = 0.0048;   // 16 g over 16 bits
  imu.lost_share = 0.01;
  imu.time_jitter_s = 0.001;
  return imu;
}

GnssModel RtkGnss() {
  GnssModel gnss;
  gnss.is_rtk = true;
  gnss.wander_horizontal_m = 0.01;
  gnss.wander_vertical_m = 0.02;
  gnss.white_horizontal_m = 0.008;
  gnss.white_vertical_m = 0.012;
  return gnss;
}

}  // namespace skyquilt::simulate
