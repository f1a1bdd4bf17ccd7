// PlaceByEvidence: the first adjustment, from where the records place the photos and, where that stands
// badly, from what the photos show alone (attempts/); the attempt that goes on is the one that stands better.
// The same for any number of threads.
#pragma once

#include "core/alignment/stages/attempt_steps.h"

namespace skyquilt::alignment {

// `by_records`: matched, not adjusted. What was tried stands in the attempt's `by_images`. Errors:
// kCancelled.
Result<Attempt> PlaceByEvidence(const ExtractedFlight& extracted, Attempt by_records,
                                const AlignOptions& options, Progress& progress);

}  // namespace skyquilt::alignment
