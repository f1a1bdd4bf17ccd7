// AlignDirectly: a map refined by comparing pictures as a whole and by nothing else, for comparison: every
// pair of photos that should overlap is shifted against each other by phase correlation of their thumbnails
// (DirectTracks), twice, the second time from where the first adjustment put them; the shifts that are
// unambiguous move the recorded poses in a bundle adjustment. Photos without any keep their recorded pose.
// Errors: kCancelled.
#pragma once

#include "core/alignment/align_flight.h"

namespace skyquilt::alignment {

Result<AlignedFlight> AlignDirectly(const poses::PosedFlight& posed, const flight::PhotoSource& source,
                                    const AlignOptions& options, AlignReport& report, Progress& progress);

}  // namespace skyquilt::alignment
