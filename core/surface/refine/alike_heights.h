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
  float most_step_m = 1.0f;      // between neighbours of one surface
  std::uint8_t many = 32;        // so many alike around it make a cell a surface's own
  std::uint8_t some = 16;        // and so many let it hang on to one, at an edge
  std::size_t least_cells = 16;  // of its own, or a surface is none
  // Two photos make ragged surfaces of some hundred cells by chance, over crowns in the wind and at the rim;
  // three hardly any. So a surface's own cells, each as many more times as further photos agree on it, come
  // to so many, or half of all its cells have that many alike.
  std::size_t least_weight = 16;
  std::size_t third_photo = 10;  // as many more cells
  std::uint8_t most = 40;
};

// Known cells that hang together with too few that are borne out become unknown. `agreeing`: photos, by cell.
void DropSpeckles(LevelHeights& level, const std::vector<std::uint8_t>& alike,
                  const std::vector<std::uint8_t>& agreeing, const SpeckleRules& rules);

}  // namespace skyquilt::surface
