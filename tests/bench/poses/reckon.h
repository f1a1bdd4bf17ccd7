// Reckon: the source paper's own step, done right: where raw inertial samples alone lead, by the trapezoid
// and by Simpson's rule, against what GNSS recorded. Each window starts from the recorded velocity and has
// the recorded attitude, so that its error is what the inertial samples alone add. Metres, seconds, frame
// `enu`. Pure; any thread. Errors: kUnprocessable where the log lacks inertial samples, attitudes or
// positions (the message says which). Source: K. Iz and M. Unel, "Aerial Image Stitching Using IMU Data from
// a UAV", equations (1)-(3).
#pragma once

#include <optional>
#include <string>

#include "core/poses/evidence/recorded_series.h"
#include "tests/bench/poses/strapdown.h"

namespace skyquilt::poses {

// Horizontal error of reckoning over windows of a fixed length, with the autopilot's attitude, in flight.
struct ReckonedDrift {
  double length_s = 0.0;
  int windows = 0;
  double trapezoid_rms_m = 0.0;
  double simpson_rms_m = 0.0;
};

// Start times, ten seconds apart, of windows of `length_s` that are wholly in flight and without holes in the
// samples or fixes. `gnss`: of the same log.
std::vector<double> WindowsInFlight(const flight::FlightLog& log, const GnssSeries& gnss, double length_s);

// Over 10, 30 and 60 s, where the log is that long.
Result<std::vector<ReckonedDrift>> DriftsOfReckoning(const flight::FlightLog& log);

}  // namespace skyquilt::poses
