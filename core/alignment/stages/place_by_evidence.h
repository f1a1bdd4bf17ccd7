// PlaceByEvidence: the first adjustment, from where the records place the photos and, where that stands
// badly, from what the photos show alone (second_leg/); the leg that goes on is the one that stands better.
// The same for any number of threads.
#pragma once

#include "core/alignment/scene/align_report.h"
#include "core/alignment/stages/leg.h"

namespace skyquilt::alignment {

struct PlacedFlight {
  Leg leg;
  SecondLegReport second_leg;  // what was tried, and why it was taken or not
};

// `by_records`: matched, not adjusted. Errors: kCancelled.
Result<PlacedFlight> PlaceByEvidence(const ExtractedFlight& extracted, Leg by_records,
                                     const AlignOptions& options, Progress& progress);

}  // namespace skyquilt::alignment
