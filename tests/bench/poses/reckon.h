// Reckon: the source paper's own step, done right: displacement and rotation between captures from raw
// inertial samples, by the trapezoid and by Simpson's rule, beside what GNSS and the autopilot recorded. Each
// interval starts from the recorded velocity and attitude, so that its error is what the inertial samples
// alone add. Metres, seconds, radians, frame `enu`. Pure; any thread. Errors: kUnprocessable where the log
// lacks inertial samples, attitudes or positions (the message says which). Source: K. Iz and M. Unel, "Aerial
// Image Stitching Using IMU Data from a UAV", equations (1)-(3).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/flight/logs/flight_log.h"
#include "core/poses/evidence/recorded_series.h"
#include "tests/bench/poses/strapdown.h"

namespace skyquilt::poses {

// What one rule makes of one interval.
struct ReckonedStep {
  Eigen::Vector3d displacement_in_enu_m = Eigen::Vector3d::Zero();
  double rotation_rad =
      0.0;               // angle of the turn from the first capture to the second, by the gyroscope alone
  double drift_m = 0.0;  // horizontal distance from the recorded displacement
};

struct ReckonedInterval {
  double from_s = 0.0;  // log clock
  double to_s = 0.0;
  std::string from_name;  // of the photo or event; empty without one
  std::string to_name;
  Eigen::Vector3d recorded_displacement_in_enu_m = Eigen::Vector3d::Zero();  // by GNSS
  double recorded_rotation_rad = 0.0;                                        // by the autopilot
  ReckonedStep trapezoid;
  ReckonedStep simpson;
};

// Horizontal error of reckoning over windows of a fixed length, with the autopilot's attitude, in flight.
struct ReckonedDrift {
  double length_s = 0.0;
  int windows = 0;
  double trapezoid_rms_m = 0.0;
  double simpson_rms_m = 0.0;
};

struct Capture {
  double t_s = 0.0;  // log clock
  std::string name;
};

struct Reckoning {
  std::vector<ReckonedInterval> intervals;
  std::vector<ReckonedDrift> drifts;  // 10, 30 and 60 s, where the log is that long
  int intervals_without_record = 0;   // passed over: no fix, no attitude, or a hole in the samples
};

// Start times, ten seconds apart, of windows of `length_s` that are wholly in flight and without holes in the
// samples or fixes. `gnss`: of the same log.
std::vector<double> WindowsInFlight(const flight::FlightLog& log, const GnssSeries& gnss, double length_s);

// `captures`: times rising. None: the drifts alone.
Result<Reckoning> ReckonBetween(const flight::FlightLog& log, const std::vector<Capture>& captures);

}  // namespace skyquilt::poses
