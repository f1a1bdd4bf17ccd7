// AlignFlight: refines recorded poses by what the photos show, and keeps every photo on the map: one without
// links stays at its pose, moved as its neighbours were. At most one decode per photo; only features and
// thumbnails are kept, about 0.4 MB per photo. The result does not depend on the number of threads. Cancelled
// through `progress`. Errors: kCancelled. Photos that cannot be decoded are placed by pose and say so.
// Method: features projected to the ground by the recorded poses, matched in windows their uncertainty
// allows; a graph of ground motions finds records that lie; bundle adjustment with the records as priors,
// twice, the second time with matches searched on the relief of the first.
#pragma once

#include "core/alignment/features/features.h"
#include "core/alignment/scene/align_report.h"
#include "core/alignment/scene/aligned_flight.h"
#include "core/alignment/stages/align_options.h"
#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/flight/photos/photo_source.h"
#include "core/poses/posed_flight.h"

namespace skyquilt::alignment {

// `found`: features of photos that were decoded before; the others are decoded here.
Result<AlignedFlight> AlignFlight(const poses::PosedFlight& recorded, const flight::PhotoSource& source,
                                  const AlignOptions& options, AlignReport& report, Progress& progress,
                                  FoundFeatures found = {});

}  // namespace skyquilt::alignment
