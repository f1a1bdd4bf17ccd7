#include "core/alignment/matching/candidate_pairs.h"

#include <algorithm>
#include <set>

namespace skyquilt::alignment {

std::vector<std::pair<int, int>> CandidatePairs(const PairQuestion& question) {
  const int count = static_cast<int>(question.photos.size());
  std::set<std::pair<int, int>> chosen;
  for (const PairSource& source : kPairSources) {
    const PartnersByPhoto partners = source(question);
    for (int i = 0; i < count; ++i) {
      if (!question.IsWanted(i)) continue;
      for (const int j : partners[i]) {
        if (j >= 0 && j < count && j != i && question.photos[j].features)
          chosen.emplace(std::min(i, j), std::max(i, j));
      }
    }
  }
  return {chosen.begin(), chosen.end()};
}

}  // namespace skyquilt::alignment
