// CandidatePairs: which photos are worth comparing when their attitude is unknown: what any source of pairs
// (pair_sources.h) says. Their number grows with the photos. Pure; any thread.
#pragma once

#include <utility>
#include <vector>

#include "core/alignment/matching/pair_sources.h"

namespace skyquilt::alignment {

// (first, second) with first < second, sorted; photos without features are in none.
std::vector<std::pair<int, int>> CandidatePairs(const PairQuestion& question);

}  // namespace skyquilt::alignment
