// Attempt: one alignment of a flight as far as it has come, its first and its last stage, and the steps that
// several stages take with it. Values; the same for any number of threads.
#pragma once

#include <string>
#include <vector>

#include "core/alignment/attempts/attempt_evidence.h"
#include "core/alignment/bundle/bundle_adjustment.h"
#include "core/alignment/from_records/matching_passes.h"
#include "core/alignment/scene/relief.h"
#include "core/alignment/stages/extract_flight.h"
#include "core/flight/remarks/remark.h"

namespace skyquilt::alignment {

struct Attempt {
  poses::PosedFlight posed;  // where the photos were taken to be before they were compared
  MatchingInput input;
  MatchedFlight matched;
  std::vector<CandidatePair> compared;  // by the first passes, whatever came of it
  Relief relief{0.0};
  BundleProblem problem;
  BundleSummary adjusted;  // by the last adjustment
  bool is_adjusted = false;
  std::vector<ControlReport> control;  // by surveyed point, once tied to them
  // Heights of all that were not believed, positions of all that were late.
  std::vector<flight::Remark> corrected_records;
  int iterations = 0;  // of all adjustments
  int pairs_by_direct = 0;
  double matching_s = 0.0, adjustment_s = 0.0;  // wall
};

// What Weigh needs of it. Keeps pointers to both.
WeighedAttempt AsWeighed(const ExtractedFlight& extracted, const Attempt& attempt);

// Tracks by the poses as they stand, and an adjustment of those.
Attempt Adjusted(Attempt attempt, const BundleOptions& bundle_options, const AlignOptions& options);

// The relief as adjusted, and pairs and matches from where the photos now lie.
Attempt Rematched(Attempt attempt, const MatchingPass& pass, const AlignOptions& options);

// The ground as the adjusted points show it.
Relief AdjustedRelief(const Attempt& attempt);

// Every match that agrees with the adjusted poses, not only those the adjustment needed: the ground is
// modelled from these.
std::vector<Track> GroundTracks(const Attempt& attempt, const AlignOptions& options);

// The photos compared where their records place them, in passes that correct records proved wrong by the
// others, and the bundle to be adjusted from there. Errors: kCancelled.
Result<Attempt> MatchByRecords(const ExtractedFlight& extracted, const AlignOptions& options,
                               Progress& progress);

// The last matching pass, on the relief that the first adjustment found, and the last adjustment.
Attempt FinishAttempt(Attempt attempt, const AlignOptions& options, Progress& progress);

}  // namespace skyquilt::alignment
