// MatchInPasses: from features to verified pairs and a pose per photo from which the adjustment starts. The
// first pass searches windows of the recorded uncertainty. What it finds shows how good the records are: that
// widens the windows of photos without a verified pair, and starts them where their flight line's common
// error puts them. Passes repeat until none connects another photo. Pure apart from threads; the result does
// not depend on their number.
#pragma once

#include <vector>

#include "core/alignment/matching/match_and_verify.h"
#include "core/alignment/scene/align_report.h"
#include "core/base/progress.h"
#include "core/poses/posed_flight.h"

namespace skyquilt::alignment {

// Views are moved to the corrected poses, `ground_sigma_m` and `sigma_turn_rad` set to what is left of their
// uncertainty. What comes back are pairs that a few matches link and the rest contradicts, of all passes.
// Stops early, with what there is, when `progress` is cancelled.
std::vector<AlignPairReport> MatchInPasses(const poses::PosedFlight& posed, const std::vector<int>& lines,
                                           MatchedFlight& matched, int threads, Progress& progress);

}  // namespace skyquilt::alignment
