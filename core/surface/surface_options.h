// What may be asked of the matching of heights. Values; any thread.
#pragma once

#include <cstdint>

namespace skyquilt::surface {

struct SurfaceOptions {
  int threads = 0;  // 0: all cores
  int block_cells = 512;
  int most_views = 5;  // that are compared at one place
  // How far off the smooth ground heights are looked for, and no further than this share of the height that
  // the photos were taken from.
  double below_ground_m = 10.0;
  double above_ground_m = 40.0;
  double most_share_of_height = 0.45;
  // By how many cells the two photos furthest apart move against each other from one height to the next.
  double shift_of_step = 0.6;
  std::int64_t photo_budget_bytes = std::int64_t{256} << 20;
};

}  // namespace skyquilt::surface
