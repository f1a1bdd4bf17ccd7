// PlaceByEvidence: the first adjustment, from where the records place the photos and, where that stands
// badly, from what the photos show alone (attempts/); the attempt that goes on is the one that stands better.
// The same for any number of threads.
#pragma once

#include "core/alignment/scene/align_report.h"
#include "core/alignment/stages/attempt_steps.h"

namespace skyquilt::alignment {

struct PlacedFlight {
  Attempt attempt;
  ByImagesReport by_images;  // what was tried, and why it was taken or not
};

// `by_records`: matched, not adjusted. Errors: kCancelled.
Result<PlacedFlight> PlaceByEvidence(const ExtractedFlight& extracted, Attempt by_records,
                                     const AlignOptions& options, Progress& progress);

}  // namespace skyquilt::alignment
