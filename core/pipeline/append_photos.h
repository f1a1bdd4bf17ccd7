// AppendPhotos: photos that were added to a finished flight, placed against it. The finished photos, their
// lenses and the ground below them stay as they are; only the new ones and those around them are looked at
// again, and beside them photos that the finished flight left out: where something ties them now, they are
// placed too. One that no record places, or that is said to be far off, is looked for in the whole map. A map
// that was moved since (by hand, to surveyed points) has the new ones where it shows the place. Nothing comes
// back when that is not to be trusted (fewer than half of the new ones tie to the photos around them, or
// several without a place share nothing with the map), or where its ground would reach too far for its cells:
// then the flight is better aligned as a whole. Blocking. Errors: those of EstimatePoses and of the
// alignment; kCancelled.
#pragma once

#include <optional>
#include <vector>

#include "core/base/progress.h"
#include "core/flight/flight.h"
#include "core/flight/photos/photo_source.h"
#include "core/pipeline/report/flight_facts.h"
#include "core/poses/posed_flight.h"

namespace skyquilt::pipeline {

// `posed`: the whole flight as recorded: finished photos, new ones, and of known.flight.left_out those that
// may be tried again. `known` gives the placed ones, which come first in the outcome. What comes back has no
// thumbnails, inputs or appearance for the new ones, and those of posed.left_out among what is left out.
Result<std::optional<FlightFacts>> AppendPhotos(const FlightFacts& known, const poses::PosedFlight& posed,
                                                const MosaicOptions& options,
                                                const flight::PhotoSource& source, Progress& progress);

// The photos that came after the first `finished` ones, and those around them.
alignment::AlignedFlight AddedAndAround(const alignment::AlignedFlight& flight, std::size_t finished);

// New photos of a camera are drawn in the range of those of their kind that are drawn already.
void KeepSampleRanges(const alignment::AlignedFlight& known, std::vector<flight::Photo>& photos);

}  // namespace skyquilt::pipeline
