#include "core/alignment/matching/pair_sources.h"

#include <algorithm>
#include <cstdlib>
#include <optional>
#include <set>

#include "core/base/median.h"
#include "core/base/parallel_for.h"

namespace skyquilt::alignment {

PartnersByPhoto NextInOrder(const PairQuestion& question) {
  PartnersByPhoto partners(question.input.Photos());
  for (int i = 0; i < static_cast<int>(partners.size()); ++i) {
    for (const int step : question.options.steps) partners[i].insert(partners[i].end(), {i - step, i + step});
  }
  return partners;
}

PartnersByPhoto NearestByPosition(const PairQuestion& question) {
  const std::vector<std::optional<Eigen::Vector3d>>& places = question.input.position_in_enu;
  PartnersByPhoto partners(places.size());
  ParallelFor(places.size(), question.threads, [&](std::size_t i) {
    if (!places[i] || !question.IsWanted(i)) return;
    std::vector<std::pair<double, int>> ranked;
    for (std::size_t j = 0; j < places.size(); ++j) {
      if (j == i || !places[j] || !question.input.features[j]) continue;
      ranked.emplace_back((*places[j] - *places[i]).head<2>().squaredNorm(), static_cast<int>(j));
    }
    partners[i] = LeastFew(std::move(ranked), question.options.nearest);
  });
  return partners;
}

PartnersByPhoto LookingAlike(const PairQuestion& question) {
  const CandidateOptions& options = question.options;
  const int looked_at = (1 + 2 * options.apart_in_order) * std::max(options.alike, options.alike_unplaced) +
                        2 * options.apart_in_order;
  PartnersByPhoto partners = question.appearance.MostAlike(looked_at, question.threads);
  for (int i = 0; i < static_cast<int>(partners.size()); ++i) {
    const int most = question.input.position_in_enu[i] ? options.alike : options.alike_unplaced;
    // The likest first, without those that another stands for.
    std::vector<int> chosen;
    for (const int j : partners[i]) {
      if (static_cast<int>(chosen.size()) >= most) break;
      const bool is_covered = std::abs(j - i) <= options.apart_in_order ||
                              std::any_of(chosen.begin(), chosen.end(), [&](int other) {
                                return std::abs(other - j) < options.apart_in_order;
                              });
      if (!is_covered) chosen.push_back(j);
    }
    partners[i] = std::move(chosen);
  }
  return partners;
}

std::vector<std::pair<int, int>> CandidatePairs(const PairQuestion& question) {
  const int count = static_cast<int>(question.input.Photos());
  std::set<std::pair<int, int>> chosen;
  for (const PairSource& source : kPairSources) {
    const PartnersByPhoto partners = source(question);
    for (int i = 0; i < count; ++i) {
      if (!question.IsWanted(i)) continue;
      for (const int j : partners[i]) {
        if (j >= 0 && j < count && j != i && question.input.features[j])
          chosen.emplace(std::min(i, j), std::max(i, j));
      }
    }
  }
  return {chosen.begin(), chosen.end()};
}

}  // namespace skyquilt::alignment
