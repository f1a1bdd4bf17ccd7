// MoveStepsToEdges: where heights step (a roof beside the ground), each cell takes the height of those around
// it that look like it: a weighted median, by likeness of gray and by distance. Steps so come to lie on edges
// of the picture instead of half a window beside them. Pure; any thread. Source: Ma, He, Wei, Sun and Wu,
// "Constant time weighted median filtering for stereo matching and beyond" (2013).
#pragma once

#include <cstdint>
#include <vector>

#include "core/surface/refine_heights.h"

namespace skyquilt::surface {

// `gray` shows each cell. A step is more than step_m within two cells; all else stays as it is.
void MoveStepsToEdges(const std::vector<std::uint8_t>& gray, float step_m, LevelHeights& level);

}  // namespace skyquilt::surface
