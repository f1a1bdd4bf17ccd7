// ExtractFlight: what each photo of a flight shows (features) beside what it records, before any photo is
// compared with another. Photos that no record places take part, in the order of capture.
#pragma once

#include "core/alignment/attempts/attempt.h"
#include "core/alignment/stages/align_options.h"
#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/flight/photos/photo_source.h"

namespace skyquilt::alignment {

Error AlignmentCancelled();

// Errors: kCancelled.
Result<ExtractedFlight> ExtractFlight(const poses::PosedFlight& recorded, const flight::PhotoSource& source,
                                      const AlignOptions& options, FoundFeatures found, Progress& progress);

}  // namespace skyquilt::alignment
