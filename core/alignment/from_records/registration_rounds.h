// RegisterInRounds: photos without partners taken into an adjusted block, those next to it first, until no
// more are found. Pure apart from threads; the result does not depend on their number.
#pragma once

#include "core/alignment/bundle/bundle_adjustment.h"
#include "core/alignment/from_records/matching_passes.h"
#include "core/alignment/scene/relief.h"
#include "core/poses/posed_flight.h"

namespace skyquilt::alignment {

// Photos with fewer tie points are not held by them.
inline constexpr int kEnoughObservations = 12;

// Moves the photos that are found in `problem`, `linked` and `input.views`; how many those are.
int RegisterInRounds(const poses::PosedFlight& posed, const Relief& relief, int threads, MatchingInput& input,
                     MatchedFlight& linked, BundleProblem& problem);

}  // namespace skyquilt::alignment
