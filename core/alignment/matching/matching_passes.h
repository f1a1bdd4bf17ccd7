// MatchInPasses: from features to links between photos and a pose for each to start the adjustment from. The
// first look believes windows of the recorded uncertainty; what it finds shows how good the records really
// are, which widens the windows of photos it could not link and starts them where their flight line's common
// error puts them; looks follow each other until no photo is newly linked. Pure apart from threads; the
// result does not depend on their number.
#pragma once

#include <string>
#include <vector>

#include "core/alignment/align_report.h"
#include "core/alignment/matching/match_and_verify.h"
#include "core/alignment/registration/correct_poses.h"
#include "core/base/progress.h"
#include "core/poses/posed_flight.h"

namespace skyquilt::alignment {

struct MatchedFlight {
  std::vector<CandidatePair> pairs;  // of the last look
  std::vector<VerifiedPair> links;   // that hold
  std::vector<CorrectedPose> corrected;
};

// `input.views` are moved to the corrected poses, `input.ground_sigma_m` and `sigma_turn_rad` set to what is
// left of their uncertainty. Stops early, with what there is, when `progress` is cancelled.
MatchedFlight MatchInPasses(const poses::PosedFlight& posed, const std::vector<int>& lines,
                            MatchingInput& input, int threads, AlignReport& report, Progress& progress);

}  // namespace skyquilt::alignment
