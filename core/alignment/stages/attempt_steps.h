// The stages of an alignment, and the steps that several of them take with an attempt. The same for any
// number of threads.
#pragma once

#include <vector>

#include "core/alignment/attempts/attempt.h"
#include "core/alignment/scene/align_report.h"
#include "core/alignment/scene/aligned_flight.h"
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
Attempt Adjusted(Attempt attempt, const BundleOptions& options);

// The relief as adjusted, and pairs and matches from where the photos now lie.
Attempt Rematched(Attempt attempt, const MatchingPass& pass, const AlignOptions& options);

// The ground as the adjusted points show it.
Relief AdjustedRelief(const Attempt& attempt);

// Every match that agrees with the adjusted poses, not only those the adjustment needed: the ground is
// modelled from these.
std::vector<Track> GroundTracks(const Attempt& attempt);

// The photos compared where their records place them, in passes that correct records proved wrong by the
// others, and the bundle to be adjusted from there. Errors: kCancelled.
Result<Attempt> MatchByRecords(const ExtractedFlight& extracted, const AlignOptions& options,
                               Progress& progress);

// The first adjustment, from where the records place the photos and, where that stands badly, from what the
// photos show alone (attempts/); the attempt that goes on is the one that stands better, and its report
// says why. `by_records`: matched, not adjusted. Errors: kCancelled.
Result<Attempt> PlaceByEvidence(const ExtractedFlight& extracted, Attempt by_records,
                                const AlignOptions& options, Progress& progress);

// The last matching pass, on the relief that the first adjustment found, and the last adjustment.
Attempt FinishAttempt(Attempt attempt, const AlignOptions& options, Progress& progress);

// Which photos count as aligned, where the others go, how far off each may be, and the tie points worth
// modelling the ground from. ground_tracks: with points that agree with the adjusted poses. Fills the
// report's photos, components and residuals. Pure; any thread.
AlignedFlight PlacePhotos(const ExtractedFlight& extracted, const Attempt& attempt,
                          const std::vector<Track>& ground_tracks, AlignReport& report);

// From an adjusted attempt to the flight that the map is made of, and what is told of it: fills the whole
// report but its total time. Errors: kUnprocessable where no photo is left to place.
Result<AlignedFlight> Conclude(const ExtractedFlight& extracted, Attempt attempt, AlignReport& report);

}  // namespace skyquilt::alignment
