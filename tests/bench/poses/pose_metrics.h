// How far estimated poses are from the truth, in the measures of the accuracy table, and whether the stated
// covariances tell the truth about it. Metres, degrees, pixels.
#pragma once

#include "core/poses/smoother/smoother.h"
#include "tests/bench/poses/analytic_flight.h"

namespace skyquilt::bench {

struct PoseMetrics {
  double position_2d_m = 0.0;  // all RMS over the photos of one flight
  double height_m = 0.0;
  double tilt_deg = 0.0;
  double yaw_deg = 0.0;
  double center_m = 0.0;  // ground error of the image centre and of the corner
  double corner_m = 0.0;
  double next_m = 0.0;     // error of one photo's centre on the ground relative to the one before
  double window_px = 0.0;  // radius of its 99 % window, from the stated covariance, in pixels of the photo
  double search_px = 0.0;  // the same for a pixel carried into the next photo: the yaw's error comes in
  double covered = 0.0;    // part of the true correspondences inside their 99 % windows
  double nees_position = 0.0;  // mean normalised squared error, one when honest
  double nees_rotation = 0.0;
  double worst_position_m = 0.0;
};

PoseMetrics Measure(const AnalyticFlight& flight, const poses::SmootherOutput& output);

}  // namespace skyquilt::bench
