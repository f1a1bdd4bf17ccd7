// SenseFlight: what the recorder of a simulated flight writes: every sensor's samples with its errors,
// generated from differences of the true path (never by integrating), as a FlightLog. A sample of an inertial
// unit is the mean over its interval and is stamped at the interval's middle. Deterministic in the seed; each
// sensor has its own stream of random numbers, so that switching one off leaves the others as they are. Any
// thread.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "core/flight/logs/flight_log.h"
#include "core/geo/local_frame.h"
#include "core/simulate/sensors/flight_path.h"

namespace skyquilt::simulate {

// The sensors' errors, with presets below. SI units, radians. Sources: data sheets of the InvenSense
// ICM-20602 and MPU-6000 for the noise densities and offsets; the wander of consumer GNSS, autopilot attitude
// and barometer as first-order Gauss-Markov processes.
struct ImuModel {
  double rate_hz = 250.0;
  double gyro_white = 7.0e-5;     // rad/s/sqrt(Hz)
  double accel_white = 1.0e-3;    // m/s2/sqrt(Hz)
  double gyro_turn_on = 0.0035;   // rad/s, 1-sigma
  double accel_turn_on = 0.02;    // m/s2, 1-sigma
  double gyro_walk = 2.0e-5;      // rad/s/sqrt(s)
  double accel_walk = 3.0e-4;     // m/s2/sqrt(s)
  double scale = 0.0;             // 1-sigma, relative, each axis
  double misalignment_rad = 0.0;  // 1-sigma, each axis pair
  double vibration_mps2 = 0.0;    // amplitude of each line below, sampled at an instant: it aliases
  std::vector<double> vibration_hz = {83.0, 121.0, 187.0};
  double gyro_step_radps = 0.0;  // quantisation
  double accel_step_mps2 = 0.0;
  double lost_share = 0.0;                        // of the samples
  double time_jitter_s = 0.0;                     // of the stamps, uniform within +-
  std::vector<std::pair<double, double>> gaps_s;  // [begin, end) without any sample
};

struct GnssModel {
  double rate_hz = 5.0;
  double wander_horizontal_m = 1.0;  // Gauss-Markov, each axis
  double wander_vertical_m = 1.8;
  double wander_correlation_s = 120.0;
  double white_horizontal_m = 0.15;
  double white_vertical_m = 0.24;
  double velocity_horizontal_mps = 0.08;
  double velocity_vertical_mps = 0.12;
  double latency_s = 0.0;  // a stamp is this much later than what it describes
  bool is_rtk = false;
  std::vector<std::pair<double, double>> outages_s;
  std::vector<std::pair<double, double>> rtk_float_s;  // RTK falls back to 30 cm wander
};

struct AttitudeModel {
  double rate_hz = 20.0;
  double white_rad = 0.00175;  // 0.1 deg
  double tilt_rad = 0.0105;    // 0.6 deg, Gauss-Markov
  double yaw_rad = 0.0436;     // 2.5 deg, Gauss-Markov
  double correlation_s = 40.0;
};

struct BaroModel {
  double rate_hz = 10.0;
  double white_m = 0.15;
  double drift_m = 1.0;  // Gauss-Markov over 300 s, zero at take-off
  double correlation_s = 300.0;
};

struct RangeModel {
  double rate_hz = 10.0;
  double white_m = 0.1;
  double relative = 0.02;
  double nearest_m = 0.2;    // blind below
  double farthest_m = 25.0;  // no echo beyond
};

struct CameraEventModel {
  double delay_s = 0.05;  // from the command to the exposure
  double delay_jitter_s = 0.015;
  double feedback_jitter_s = 0.0005;  // of the measured shutter's stamp
  bool has_feedback = true;           // false: the log holds the command only
  double lost_share = 0.0;
  double doubled_share = 0.0;
};

struct SensorOptions {
  bool has_imu = true, has_gnss = true, has_attitude = true, has_baro = true, has_range = false;
  ImuModel imu;
  GnssModel gnss;
  AttitudeModel attitude;
  BaroModel baro;
  RangeModel range;
  CameraEventModel events;
  std::uint32_t seed = 1;
};

ImuModel IcmClassImu();  // as the defaults
ImuModel MpuClassImu();  // older: 400 ug/sqrt(Hz), 5 mg, 0.5 deg/s
// Adds what real logs have: scale and misalignment, quantisation, lost samples, stamp jitter, vibration.
ImuModel WithDefects(ImuModel imu, double vibration_mps2);
GnssModel RtkGnss();  // 8 mm white, 10/10/20 mm wander

// exposures_s: true times of exposure on the path's clock, rising. utc_at_zero: the UTC of the path's t = 0.
// Ground under the range finder is the plane z = 0.
flight::FlightLog SenseFlight(const FlightPath& path, const geo::LocalFrame& frame,
                              const std::vector<double>& exposures_s, flight::UtcTime utc_at_zero,
                              const SensorOptions& options);

}  // namespace skyquilt::simulate
