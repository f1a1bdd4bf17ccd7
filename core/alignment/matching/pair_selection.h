// SelectPairs: which photos are worth comparing: those whose footprints overlap where the poses put them,
// grown by what the poses are unsure of; the most overlapping ones and the best in each direction, so that
// neighbouring lines are tied as well as neighbours in a line. Photos from far above and far below are chosen
// beside those of like height, and not at all where no feature can show in both. Cost grows with photos times
// neighbours. Pure; any thread.
#pragma once

#include <compare>
#include <vector>

#include "core/alignment/scene/view.h"

namespace skyquilt::alignment {

struct CandidatePair {
  int first = 0;  // < second
  int second = 0;
  double overlap = 0.0;  // share of the one's picture that the other sees; of unlike ones the wider's

  auto operator<=>(const CandidatePair&) const = default;
};

// Sorted by (first, second). ground_sigma_m: how far off each photo may lie on the ground, one sigma.
std::vector<CandidatePair> SelectPairs(const std::vector<View>& views,
                                       const std::vector<double>& ground_sigma_m, const Relief& relief);

// Whether features of the one can be seen in the other, by how wide the ground is that each shows.
bool AreOfComparableScale(const View& a, const View& b);

}  // namespace skyquilt::alignment
