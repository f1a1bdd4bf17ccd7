// Semi-global matching over sheets of heights: the cost of each height of a cell, summed along eight paths on
// which the height may stay, move by one step for a small penalty, or jump for a large one that is lower
// where the picture has an edge. Costs are of absolute heights: neighbours whose sheets begin elsewhere are
// compared height for height, to half a step, so that following the sheets costs nothing. Pure; any thread;
// the same bits on any processor. Source: Hirschmueller, "Stereo processing by semiglobal matching and mutual
// information" (2008); over the ground's cells Bethmann and Luhmann (2015); free slopes after Scharstein,
// Taniai and Sinha (2017).
#pragma once

#include <cstdint>
#include <vector>

#include "core/surface/paths/height_sheets.h"

namespace skyquilt::surface {

// For each cell its heights in order: of first sheets, and of second ones by their number.
struct SheetCosts {
  std::vector<std::uint8_t> first, second;  // at most kMaxPathCost - JumpPenalties::most
};

struct SheetSums {
  std::vector<std::uint16_t> first, second;
};

inline constexpr int kMaxPathCost = 254;

struct JumpPenalties {
  int step = 8;         // for one step up or down
  int most = 44;        // for more, where the picture is even
  int least = 16;       // and across an edge of it
  int whole_edge = 40;  // the difference of gray that is an edge
};

// `gray` shows each cell. What `sums` held before is lost, its memory serves again.
void SumAlongPaths(const HeightSheets& sheets, const SheetCosts& costs, const std::vector<std::uint8_t>& gray,
                   const JumpPenalties& penalties, SheetSums& sums);

}  // namespace skyquilt::surface
