#include "core/alignment/matching/candidate_pairs.h"

#include <algorithm>
#include <cstdlib>
#include <set>

#include "core/base/parallel_for.h"

namespace skyquilt::alignment {

namespace {

// The likest first, without those that another stands for.
std::vector<int> Apart(int photo, const std::vector<int>& likest, int most, int apart) {
  std::vector<int> chosen;
  for (const int j : likest) {
    if (static_cast<int>(chosen.size()) >= most) break;
    if (apart > 0 && std::abs(j - photo) <= apart) continue;
    const bool is_covered = apart > 0 && std::any_of(chosen.begin(), chosen.end(),
                                                     [&](int other) { return std::abs(other - j) < apart; });
    if (!is_covered) chosen.push_back(j);
  }
  return chosen;
}

}  // namespace

std::vector<std::pair<int, int>> CandidatePairs(const std::vector<RegistrationPhoto>& photos,
                                                const Appearance& appearance, const CandidateOptions& options,
                                                const std::vector<char>& wanted, int threads) {
  const int count = static_cast<int>(photos.size());
  const auto at = [&](int i) -> const RegistrationPhoto& { return photos[i]; };
  const auto is_wanted = [&](int i) { return wanted.empty() || wanted[i] != 0; };
  std::vector<std::vector<int>> near(photos.size());
  ParallelFor(photos.size(), threads, [&](std::size_t i) {
    if (!photos[i].position_in_enu || !photos[i].features || !is_wanted(static_cast<int>(i))) return;
    std::vector<std::pair<double, int>> ranked;
    for (int j = 0; j < count; ++j) {
      if (j == static_cast<int>(i) || !at(j).position_in_enu || !at(j).features) continue;
      ranked.emplace_back((*at(j).position_in_enu - *photos[i].position_in_enu).head<2>().squaredNorm(), j);
    }
    const std::size_t kept = std::min<std::size_t>(static_cast<std::size_t>(options.nearest), ranked.size());
    std::partial_sort(ranked.begin(), ranked.begin() + static_cast<std::ptrdiff_t>(kept), ranked.end());
    for (std::size_t k = 0; k < kept; ++k) near[i].push_back(ranked[k].second);
  });
  const int looked_at = (1 + 2 * options.apart_in_order) * std::max(options.alike, options.alike_unplaced) +
                        2 * options.apart_in_order;
  const std::vector<std::vector<int>> alike = appearance.MostAlike(looked_at, threads);
  std::set<std::pair<int, int>> chosen;
  for (int i = 0; i < count; ++i) {
    if (!is_wanted(i) || !at(i).features) continue;
    const auto choose = [&](int j) {
      if (j >= 0 && j < count && j != i && at(j).features) chosen.emplace(std::min(i, j), std::max(i, j));
    };
    for (const int step : options.steps) {
      choose(i - step);
      choose(i + step);
    }
    for (const int j : near[i]) choose(j);
    const int most = at(i).position_in_enu ? options.alike : options.alike_unplaced;
    for (const int j : Apart(i, alike[i], most, options.apart_in_order)) choose(j);
  }
  return {chosen.begin(), chosen.end()};
}

}  // namespace skyquilt::alignment
