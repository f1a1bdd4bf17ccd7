// What a flight's records say already of what was asked for: better refused before photos are compared.
// Records may be wrong, so that only what is surely in vain is; whoever makes the map looks again. Pure.
// Errors: kUnprocessable, kInvalidArgument.
#pragma once

#include "core/alignment/scene/aligned_flight.h"
#include "core/base/result.h"
#include "core/geo/boundary.h"
#include "core/pipeline/mosaic_options.h"
#include "core/poses/posed_flight.h"

namespace skyquilt::pipeline {

// No photo can show any of it.
Result<void> CheckBoundaryIsNear(const poses::PosedFlight& posed, const geo::Boundary& boundary);
// What lies in a zone of UTM cannot be written where there is none.
Result<void> CheckUtmByRecords(const poses::PosedFlight& posed, const MosaicOptions& options);
// The same before anything is drawn: also of a flight that an earlier run placed, or surveyed points did.
Result<void> CheckUtmOfPlaced(const alignment::AlignedFlight& flight, const MosaicOptions& options);
// By the heights that were recorded.
Result<void> CheckGsdByRecords(const poses::PosedFlight& posed, const MosaicOptions& options);

}  // namespace skyquilt::pipeline
