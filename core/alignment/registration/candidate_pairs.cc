#include "core/alignment/registration/candidate_pairs.h"

#include <algorithm>
#include <set>

#include "core/base/parallel_for.h"

namespace skyquilt::alignment {

std::vector<std::pair<int, int>> CandidatePairs(const std::vector<RegistrationPhoto>& photos,
                                                const Appearance& appearance, const CandidateOptions& options,
                                                int threads) {
  const int count = static_cast<int>(photos.size());
  const auto at = [&](int i) -> const RegistrationPhoto& { return photos[static_cast<std::size_t>(i)]; };
  std::set<std::pair<int, int>> chosen;
  const auto choose = [&](int i, int j) {
    if (i != j && at(i).features && at(j).features) chosen.emplace(std::min(i, j), std::max(i, j));
  };
  for (int i = 0; i < count; ++i) {
    for (int j = i + 1; j <= std::min(count - 1, i + options.in_order); ++j) choose(i, j);
  }
  std::vector<std::vector<int>> near(photos.size());
  ParallelFor(photos.size(), threads, [&](std::size_t i) {
    if (!photos[i].position_in_enu || !photos[i].features) return;
    std::vector<std::pair<double, int>> ranked;
    for (int j = 0; j < count; ++j) {
      if (j == static_cast<int>(i) || !at(j).position_in_enu || !at(j).features) continue;
      ranked.emplace_back((*at(j).position_in_enu - *photos[i].position_in_enu).head<2>().squaredNorm(), j);
    }
    const std::size_t kept = std::min<std::size_t>(static_cast<std::size_t>(options.nearest), ranked.size());
    std::partial_sort(ranked.begin(), ranked.begin() + static_cast<std::ptrdiff_t>(kept), ranked.end());
    for (std::size_t k = 0; k < kept; ++k) near[i].push_back(ranked[k].second);
  });
  const int most_alike = std::max(options.alike, options.alike_unplaced);
  const std::vector<std::vector<int>> alike = appearance.MostAlike(most_alike, threads);
  for (int i = 0; i < count; ++i) {
    for (const int j : near[static_cast<std::size_t>(i)]) choose(i, j);
    const std::vector<int>& likest = alike[static_cast<std::size_t>(i)];
    const int wanted = at(i).position_in_enu ? options.alike : options.alike_unplaced;
    for (std::size_t k = 0; k < likest.size() && static_cast<int>(k) < wanted; ++k) choose(i, likest[k]);
  }
  return {chosen.begin(), chosen.end()};
}

}  // namespace skyquilt::alignment
