// OpenLean: by how much a map may lean though it lies on its positions. Positions on one line, or at one
// spot, say nothing of a turn about it: there the cameras' angles alone hold the map, and what all of them
// share (a gimbal that hangs a degree to the side, a camera that flew crabwise) no comparison of the photos
// shows. The ground then lies off sideways by the height flown times that angle. Pure; any thread.
#pragma once

#include <vector>

#include "core/alignment/scene/aligned_flight.h"

namespace skyquilt::pipeline {

struct OpenLean {
  double sigma_rad = 0.0;  // of what the angles share, where nothing else holds the map
  double off_m = 0.0;      // of the ground, 1 sigma: square mean of both horizontal axes
};

// `places`: of the positions that place the map, in enu; `noise_m`: how far these err apart, each axis;
// `unsaid_deg`: what the angles of photos that recorded none may share.
OpenLean OpenLeanOf(const alignment::AlignedFlight& flight, const std::vector<Eigen::Vector2d>& places,
                    double noise_m, double unsaid_deg);

}  // namespace skyquilt::pipeline
