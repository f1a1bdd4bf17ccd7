// Steps of heights (a roof beside the ground) moved to where the photos have them, instead of some cells
// beside them: a cell near a step may lie on either side of it, and two things say on which. The cells around
// vote, the nearer and the more alike in gray the more (of two heights that is a weighted median); and photos
// compare the cell alone at both heights while those around it stay. Pure; any thread; the same bits on any
// processor. After Ma, He, Wei, Sun and Wu, "Constant time weighted median filtering for stereo matching and
// beyond" (2013).
#pragma once

#include <cstdint>
#include <vector>

#include "core/surface/refine/refine_heights.h"

namespace skyquilt::surface {

struct OtherSides {
  // By cell: the height of the most alike cell across the step; the cell's own where no step is near.
  std::vector<float> heights_m;
  std::vector<float> votes;  // from -1, all for the other side, to 1, all for its own
};

// `gray` shows each cell. A step is more than step_m between neighbours.
OtherSides FindOtherSides(const LevelHeights& level, const std::vector<std::uint8_t>& gray, float step_m);

// `worse`: by how much the cell's cost (from 0 to 96) is larger at its other height, meant over the 3 x 3
// cells that have one on the same side.
void TakeBetterSides(const OtherSides& sides, const std::vector<std::int16_t>& worse, LevelHeights& level);

}  // namespace skyquilt::surface
