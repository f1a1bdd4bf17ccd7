// TrustHeights: how far a map is laid on the heights of its cells and how far on the smooth ground, by square
// of kTrustSquareCells cells, row by row from the south-west. Nothing is believed where fewer photos look
// than one height takes to be borne out by another: at the rim of a flight, where two photos show one tree
// and a third does not, it stands neither here nor there. Two photos are enough where two thirds of what lies
// around were measured, as houses and roads are and crowns and water are not. Pure; any thread.
#pragma once

#include <cstdint>
#include <vector>

#include "core/surface/dense_surface.h"

namespace skyquilt::pipeline {

inline constexpr int kTrustSquareCells = 16;

// The share of the cells of a square and of those beside it (5 x 5) whose height was measured. columns x rows
// squares hold all cells of the grid; the last may have few or none.
std::vector<float> MeasuredAround(const surface::SurfaceGrid& grid,
                                  const std::vector<std::uint8_t>& agreeing_photos, int columns, int rows);

// 0 to 1 by square; no square is more than a sixth above those beside it.
std::vector<float> TrustHeights(const std::vector<std::uint8_t>& photos, const std::vector<float>& measured,
                                int columns, int rows);

}  // namespace skyquilt::pipeline
