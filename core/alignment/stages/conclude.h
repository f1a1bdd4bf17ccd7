// Conclude: from an adjusted attempt to the flight that the map is made of, and what is told of it. Pure; any
// thread.
#pragma once

#include "core/alignment/attempts/attempt.h"
#include "core/alignment/scene/align_report.h"
#include "core/alignment/scene/aligned_flight.h"
#include "core/alignment/stages/align_options.h"
#include "core/base/result.h"

namespace skyquilt::alignment {

// Fills the whole report but its total time. Errors: kUnprocessable where no photo is left to place.
Result<AlignedFlight> Conclude(const poses::PosedFlight& recorded, const ExtractedFlight& extracted,
                               Attempt attempt, const AlignOptions& options, AlignReport& report);

}  // namespace skyquilt::alignment
