// CommonQuarterTurn: by which quarter or half turn a whole flight's pictures lie against their recorded yaw,
// as those of a camera mounted sideways do. Between themselves such photos agree; what gives them away is the
// way from one to the next, which the pictures show turned against the recorded positions. Pure; any thread.
#pragma once

#include <vector>

#include "core/alignment/from_records/ground_graph.h"
#include "core/alignment/scene/matches.h"

namespace skyquilt::alignment {

// The turn about the vertical, counter-clockwise, that every photo needs: 0, or +-pi/2, or pi where at least
// four of five pairs (and no fewer than eight) say so. `pairs` of views as recorded.
double CommonQuarterTurn(const std::vector<GroundPrior>& recorded, const std::vector<VerifiedPair>& pairs);

}  // namespace skyquilt::alignment
