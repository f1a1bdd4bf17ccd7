// TakeInLost: photos that an adjusted alignment left out, registered against it by resection (RegisterLost)
// and taken in as if they had always been linked: also those whose records place them nowhere. The rest of
// the alignment stays for the next adjustment to move. The same for any number of threads.
#pragma once

#include <vector>

#include "core/alignment/attempts/attempt_evidence.h"
#include "core/alignment/bundle/bundle_adjustment.h"
#include "core/alignment/from_records/matching_passes.h"
#include "core/poses/posed_flight.h"

namespace skyquilt::alignment {

// `attempt` is the alignment; `tracks` what its photos see, in enu; `relief` the ground. How many they are.
// None where too many are lost for the alignment to be sound.
int TakeInLost(const WeighedAttempt& attempt, const std::vector<Track>& tracks, const Relief& relief,
               int threads, poses::PosedFlight& posed, MatchingInput& input, MatchedFlight& linked,
               BundleProblem& problem);

// Whether there are photos for it.
bool HasLost(const AttemptEvidence& evidence);

}  // namespace skyquilt::alignment
