// MoveStepsToEdges: where heights step (a roof beside the ground), the cells around vote on which side of the
// step a cell lies, the nearer and the more alike in gray the more; one on the wrong side takes the height of
// the most alike of the other. Steps so come to lie on edges of the picture instead of some cells beside
// them. Pure; any thread; the same bits on any processor. After Ma, He, Wei, Sun and Wu, "Constant time
// weighted median filtering for stereo matching and beyond" (2013): of two heights a weighted median is a
// vote.
#pragma once

#include <cstdint>
#include <vector>

#include "core/surface/refine/refine_heights.h"

namespace skyquilt::surface {

// `gray` shows each cell. A step is more than step_m within two cells; all else stays as it is.
void MoveStepsToEdges(const std::vector<std::uint8_t>& gray, float step_m, LevelHeights& level);

}  // namespace skyquilt::surface
