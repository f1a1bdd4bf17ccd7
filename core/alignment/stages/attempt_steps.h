// What each photo of a flight shows, the first and the last stage of an attempt, and the steps that several
// stages take with it. The same for any number of threads.
#pragma once

#include <vector>

#include "core/alignment/attempts/attempt.h"
#include "core/alignment/stages/align_options.h"
#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/flight/photos/photo_source.h"

namespace skyquilt::alignment {

Error AlignmentCancelled();

// What each photo shows (features) beside what it records, before any photo is compared with another. Photos
// that no record places take part, in the order of capture. Errors: kCancelled.
Result<ExtractedFlight> ExtractFlight(const poses::PosedFlight& recorded, const flight::PhotoSource& source,
                                      const AlignOptions& options, FoundFeatures found, Progress& progress);

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
