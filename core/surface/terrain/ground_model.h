// GroundUnder: the ground below what stands on it, from a grid of heights: what an opening by ever wider
// squares cuts off by more than ground can climb is no ground, and is bridged from the ground around it.
// Metres of one height, row by row; NaN where there is none, which is bridged likewise. Pure; any thread.
// Source: Zhang and others, "A progressive morphological filter for removing nonground measurements from
// airborne LIDAR data" (2003).
#pragma once

#include <vector>

#include "core/surface/ground_below.h"

namespace skyquilt::surface {

// heights_m: of columns x rows cells; those of the ground are all NaN where these are.
GroundModel GroundUnder(const std::vector<float>& heights_m, int columns, int rows, double cell_m);

}  // namespace skyquilt::surface
