// PickHeights: of each cell's heights the one with the least sum over all paths, between steps by a parabola
// through the costs of its neighbourhood (sums have a kink at the least one and say nothing of what lies
// between steps); what is expected where nothing was compared. Metres of enu. Pure; any thread; the same bits
// on any processor.
#pragma once

#include <cstdint>
#include <vector>

#include "core/surface/paths/semi_global.h"

namespace skyquilt::surface {

struct PickedHeights {
  std::vector<float> heights_m;
  // By how much the sum of every height more than two steps away is larger.
  std::vector<std::uint16_t> margins;
  // By how much the cell's own cost is below the mean of its sheet: what its own picture has to say, while
  // sums have a least one also where the picture is even and paths only carry on what lies around. 0 at
  // least.
  std::vector<std::uint8_t> contrasts;
};

// Sums are at most eight times kMaxPathCost, as SumAlongPaths has them.
PickedHeights PickHeights(const HeightSheets& sheets, const SheetCosts& costs, const SheetSums& sums);

}  // namespace skyquilt::surface
