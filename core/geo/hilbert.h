// Place of a cell along the Hilbert curve of a 2^order square. Pure; any thread. The children of a quadtree
// cell are neighbours on the curve, so a pyramid can be closed as the walk leaves each parent. Source: D.
// Hilbert (1891); iterative form after C. H. Hamilton, Compact Hilbert Indices (2006).
#pragma once

#include <cstdint>

namespace skyquilt::geo {

std::uint64_t HilbertIndex(int order, std::uint32_t x, std::uint32_t y);

}  // namespace skyquilt::geo
