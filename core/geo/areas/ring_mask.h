// MaskRings: which cells of a grid have their middles within rings of edges, by crossings along each row:
// even and odd, so that a hole is a ring like another. Places counted in cells from the grid's corner,
// columns and rows as they rise. Memory: of the crossings of 256 rows. Pure; any thread. Nothing fails.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace skyquilt::geo {

struct RingEdge {
  double x0 = 0.0, y0 = 0.0, x1 = 0.0, y1 = 0.0;
};

// Part of the grid that is masked: its first cell, and how many.
struct MaskWindow {
  double left = 0.0, top = 0.0;
  std::size_t columns = 0, rows = 0;
};

// `inside`: row by row; cells within become 1, the others stay as they are.
void MaskRings(const std::vector<RingEdge>& edges, const MaskWindow& window,
               std::vector<std::uint8_t>& inside);

}  // namespace skyquilt::geo
