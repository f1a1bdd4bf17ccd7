// MatchInPasses: from features to verified pairs and a pose per photo from which the adjustment starts. The
// first pass searches windows of the recorded uncertainty. What it finds shows how good the records are: that
// widens the windows of photos without a verified pair, and starts them where their flight line's common
// error puts them. Passes repeat until none connects another photo. Pure apart from threads; the result does
// not depend on their number.
#pragma once

#include <vector>

#include "core/alignment/matching/match_and_verify.h"
#include "core/alignment/scene/align_report.h"
#include "core/alignment/scene/matches.h"
#include "core/alignment/scene/priors.h"
#include "core/base/progress.h"
#include "core/poses/posed_flight.h"

namespace skyquilt::alignment {

struct MatchedFlight {
  std::vector<CandidatePair> pairs;  // candidates of the last pass
  std::vector<PhotoPair> links;      // verified, and not contradicted by the others
  std::vector<CorrectedPose> corrected;
  std::vector<AlignPairReport> rejected;  // linked by a few matches, contradicted by the rest; of all passes
};

// `input.views` are moved to the corrected poses, `input.ground_sigma_m` and `sigma_turn_rad` set to what is
// left of their uncertainty. Stops early, with what there is, when `progress` is cancelled.
MatchedFlight MatchInPasses(const poses::PosedFlight& posed, const std::vector<int>& lines,
                            MatchingInput& input, int threads, Progress& progress);

}  // namespace skyquilt::alignment
