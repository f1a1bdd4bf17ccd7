// DirectTracks: ties between photos that have too few features in common, from their pictures as a whole:
// both thumbnails are projected to the ground where their poses put them, freed of slow brightness changes,
// and shifted against each other by phase correlation (Kuglin and Hines, 1975). Believed only when one shift
// stands out from all others, the poses allow it, and a repetition from the shifted place finds nothing left
// to shift. Pure; any thread.
#pragma once

#include <vector>

#include "core/alignment/matching/match_and_verify.h"
#include "core/alignment/scene/tracks.h"

namespace skyquilt::alignment {

// Ties for photos with too few verified pairs, as two-view tracks for the adjustment.
std::vector<Track> DirectTracks(const MatchedFlight& input, const Relief& relief, int threads);

// Whether a tie agrees with where both photos now lie.
bool Agrees(const std::vector<View>& views, const Track& tie);

// By photo, how many of the ties agree with where it now lies.
std::vector<int> CountTies(const std::vector<View>& views, const std::vector<Track>& ties);

}  // namespace skyquilt::alignment
