// GroundUnder: the ground below what stands on it, from a grid of heights: what an opening by ever wider
// squares cuts off by more than ground can climb is no ground, and is bridged from the ground around it.
// Metres of enu, row by row. Pure; any thread. Source: Zhang and others, "A progressive morphological filter
// for removing nonground measurements from airborne LIDAR data" (2003).
#pragma once

#include <cstdint>
#include <vector>

#include "core/surface/dense_surface.h"

namespace skyquilt::surface {

struct GroundOptions {
  double widest_thing_m = 60.0;  // what is wider than this counts as ground
  double slope = 0.3;            // that ground may have
  double least_height_m = 0.3;   // what stands less high than this is ground
  double most_step_m = 2.5;      // what stands higher is none, however wide the square
};

struct GroundModel {
  std::vector<float> heights_m;
  std::vector<std::uint8_t> is_ground;  // 0 where bridged
};

// heights_m: of columns x rows cells, all numbers.
GroundModel GroundUnder(const std::vector<float>& heights_m, int columns, int rows, double cell_m,
                        const GroundOptions& options = {});

}  // namespace skyquilt::surface
