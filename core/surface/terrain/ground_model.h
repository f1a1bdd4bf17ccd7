// GroundUnder: the ground below what stands on it, from a grid of heights: what an opening by ever wider
// squares cuts off by more than ground can climb is no ground, and is bridged from the ground around it.
// Metres of one height, row by row; NaN where there is none, which is bridged likewise. Pure; any thread.
// Source: Zhang and others, "A progressive morphological filter for removing nonground measurements from
// airborne LIDAR data" (2003).
#pragma once

#include <vector>

#include "core/surface/ground_below.h"

namespace skyquilt::surface {

struct GroundOptions {
  double widest_thing_m = 60.0;  // what is wider than this counts as ground
  double slope = 0.3;            // that ground may have
  double least_height_m = 0.3;   // what stands less high than this is ground
  double most_step_m = 2.5;      // what stands higher is none, however wide the square
  double least_pit_m = 1.0;      // what lies deeper within a few cells is no ground either, but a mistake
};

// heights_m: of columns x rows cells; those of the ground are all NaN where these are.
GroundModel GroundUnder(const std::vector<float>& heights_m, int columns, int rows, double cell_m,
                        const GroundOptions& options = {});

}  // namespace skyquilt::surface
