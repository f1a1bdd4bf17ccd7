// SelectPairs: which photos are worth comparing: those whose footprints overlap where the poses put them,
// grown by what the poses are unsure of; the most overlapping ones and the best in each direction, so that
// neighbouring lines are tied as well as neighbours in a line. Photos from far above and far below are chosen
// beside those of like height, and not at all where no feature can show in both. Cost grows with photos times
// neighbours. Pure; any thread.
#pragma once

#include <vector>

#include "core/alignment/scene/matches.h"
#include "core/alignment/scene/view.h"

namespace skyquilt::alignment {

// Candidates, sorted by (first, second), first < second. ground_sigma_m: how far off each photo may lie on
// the ground, one sigma.
std::vector<PhotoPair> SelectPairs(const std::vector<View>& views, const std::vector<double>& ground_sigma_m,
                                   const Relief& relief);

// Whether features of the one can be seen in the other, by how wide the ground is that each shows.
bool AreOfComparableScale(const View& a, const View& b);

}  // namespace skyquilt::alignment
