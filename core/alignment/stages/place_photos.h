// PlacePhotos: from the adjusted bundle to the flight the map is made of: which photos count as aligned,
// where the others go, how far off each may be, and the tie points worth modelling the ground from. Pure; any
// thread.
#pragma once

#include <vector>

#include "core/alignment/attempts/attempt.h"
#include "core/alignment/stages/doubt_photos.h"

namespace skyquilt::alignment {

// ground_tracks: with points that agree with the adjusted poses. Fills the report's photos, components and
// residuals.
AlignedFlight PlacePhotos(const ExtractedFlight& extracted, const Attempt& attempt,
                          const std::vector<Track>& ground_tracks, const std::vector<PhotoDoubt>& doubts,
                          AlignReport& report);

}  // namespace skyquilt::alignment
