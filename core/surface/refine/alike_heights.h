// What tells a measured height from chance: neighbours that were picked apart from each other and agree.
// Where photos show nothing alike (crowns in the wind, water, another thing in each photo) the least of many
// costs lies as far below the others as where they match, but heights stray from cell to cell. Metres. Pure;
// any thread; the same bits on any processor.
#pragma once

#include <cstdint>
#include <vector>

#include "core/surface/refine/refine_heights.h"

namespace skyquilt::surface {

inline constexpr int kAlikeReach = 3;  // cells to each side
inline constexpr int kMaxAlike = (2 * kAlikeReach + 1) * (2 * kAlikeReach + 1) - 1;

// How many of the 48 cells around each lie within `within_m` of it; beyond the border there are none.
std::vector<std::uint8_t> CountAlike(const LevelHeights& level, float within_m);

struct SpeckleRules {
  float most_step_m = 1.0f;  // between neighbours of one surface
  std::uint8_t many = 32;    // so many alike around it make a cell a surface's own
  std::uint8_t some = 16;    // and so many let it hang on to one, at an edge
  int least_cells = 16;      // of its own, or a surface is none
};

// Known cells that hang together with too few that are borne out become unknown.
void DropSpeckles(LevelHeights& level, const std::vector<std::uint8_t>& alike, const SpeckleRules& rules);

}  // namespace skyquilt::surface
