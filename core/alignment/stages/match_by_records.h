// MatchByRecords: the photos compared where their records place them, in passes that correct records proved
// wrong by the others, and the bundle to be adjusted from there. The same for any number of threads.
#pragma once

#include "core/alignment/stages/attempt.h"

namespace skyquilt::alignment {

// Errors: kCancelled.
Result<Attempt> MatchByRecords(const ExtractedFlight& extracted, const AlignOptions& options,
                               Progress& progress);

}  // namespace skyquilt::alignment
