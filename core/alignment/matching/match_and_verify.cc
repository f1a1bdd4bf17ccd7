#include "core/alignment/matching/match_and_verify.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <set>

#include "core/alignment/matching/guided_matching.h"
#include "core/alignment/matching/verified_pair.h"
#include "core/base/parallel_for.h"
#include "core/base/trace.h"

namespace skyquilt::alignment {
namespace {

constexpr int kLostFeatures = 700;
constexpr int kLostMinMatches = 14;
constexpr int kMaxPairsOfALostPhoto = 10;
constexpr double kPromisingOverlap = 0.3;

}  // namespace

GroundKeypoints ProjectAllToGround(const MatchedFlight& input, const Relief& relief, int threads) {
  GroundKeypoints projected(input.views.size());
  ParallelFor(input.views.size(), threads, [&](std::size_t i) {
    const PhotoFeatures* features = input.features[i];
    if (features) projected[i] = ProjectToGround(*features, input.views[i], relief);
  });
  return projected;
}

std::vector<PhotoPair> MatchAndVerify(const MatchedFlight& input, const GroundKeypoints& projected,
                                      const MatchingPass& pass, int threads) {
  return ParallelCollect(input.pairs.size(), threads, [&](std::size_t p) -> std::optional<PhotoPair> {
    const int i = input.pairs[p].first;
    const int j = input.pairs[p].second;
    if (!input.features[i] || !input.features[j]) return std::nullopt;
    const TraceSpan span("match pair");
    const double width_m = 0.5 * (input.views[i].WidthM() + input.views[j].WidthM());
    const double sigma_turn = std::hypot(input.sigma_turn_rad[i], input.sigma_turn_rad[j]);
    const double turned_away_m = 0.3 * width_m * std::min(1.5, sigma_turn);
    const double sigma_m =
        std::hypot(std::hypot(input.ground_sigma_m[i], input.ground_sigma_m[j]), turned_away_m);
    MatchWindow window;
    window.radius_m =
        std::min(1.2 * width_m, std::max(pass.min_radius_share * width_m, pass.sigmas * sigma_m));
    window.max_turn_rad =
        pass.sigmas > 0.0 ? std::max(pass.max_turn_rad, 3.0 * sigma_turn + 0.3) : pass.max_turn_rad;
    window.max_distance_ratio = pass.max_distance_ratio;
    std::vector<KeypointMatch> matches = MatchOnGround(input.features, projected, i, j, window);
    if (!pass.fit_motion) {
      if (static_cast<int>(matches.size()) < pass.min_matches) return std::nullopt;
      matches.shrink_to_fit();
      return PhotoPair{i, j, {}, std::move(matches), 0.0};
    }
    VerificationOptions options;
    options.first_tolerance_m =
        std::max(pass.tolerance_share * width_m, 0.5 * std::min(window.radius_m, 0.1 * width_m));
    options.last_tolerance_m = pass.tolerance_share * width_m;
    const Eigen::Vector3d apart_m = input.views[j].CenterInEnu() - input.views[i].CenterInEnu();
    options.baseline_m = {apart_m.x(), apart_m.y()};
    options.search_area_m2 = std::numbers::pi * window.radius_m * window.radius_m;
    options.any_turn = window.max_turn_rad > 1.5;
    options.min_matches = pass.min_matches;
    return VerifyOnGround(projected, i, j, matches, options);
  });
}

std::vector<PhotoPair> MatchLostPhotos(const MatchedFlight& input, const GroundKeypoints& projected,
                                       const std::vector<PhotoPair>& verified, int threads) {
  const int count = static_cast<int>(input.views.size());
  std::vector<int> promising(count, 0);
  const std::vector<int> linked = CountPairs(count, verified);
  std::set<std::pair<int, int>> done;
  for (const PhotoPair& pair : verified) done.emplace(pair.first, pair.second);
  for (const PhotoPair& pair : input.pairs) {
    if (pair.overlap < kPromisingOverlap) continue;
    ++promising[pair.first];
    ++promising[pair.second];
  }
  const auto is_lost = [&](int i) {
    return input.features[i] && (linked[i] == 0 || (linked[i] < 3 && 3 * linked[i] < promising[i]));
  };
  // Neighbours in time first: they are near whatever the positions say. Then the most overlapping.
  std::vector<PhotoPair> by_overlap = input.pairs;
  std::stable_sort(by_overlap.begin(), by_overlap.end(),
                   [](const PhotoPair& a, const PhotoPair& b) { return a.overlap > b.overlap; });
  std::vector<int> taken(count, 0);
  std::vector<std::pair<int, int>> chosen;
  const auto want = [&](int lost, int first, int second) {
    if (taken[lost] >= kMaxPairsOfALostPhoto || !input.features[first] || !input.features[second] ||
        !AreOfComparableScale(input.views[first], input.views[second]))
      return;
    if (!done.emplace(first, second).second) return;
    ++taken[lost];
    chosen.emplace_back(first, second);
  };
  for (int i = 0; i < count; ++i) {
    if (!is_lost(i)) continue;
    for (const int step : {-1, 1, -2, 2}) {
      const int other = i + step;
      if (other >= 0 && other < count) want(i, std::min(i, other), std::max(i, other));
    }
  }
  for (const PhotoPair& pair : by_overlap) {
    if (is_lost(pair.first)) {
      want(pair.first, pair.first, pair.second);
    } else if (is_lost(pair.second)) {
      want(pair.second, pair.first, pair.second);
    }
  }
  std::sort(chosen.begin(), chosen.end());
  return ParallelCollect(chosen.size(), threads, [&](std::size_t p) {
    const auto [i, j] = chosen[p];
    const double width_m = 0.5 * (input.views[i].WidthM() + input.views[j].WidthM());
    const MatchWindow window{.max_distance_ratio = 0.8, .max_features = kLostFeatures};
    return VerifyOnGround(projected, i, j, MatchOnGround(input.features, projected, i, j, window),
                          {.first_tolerance_m = 0.07 * width_m,
                           .last_tolerance_m = 0.02 * width_m,
                           .baseline_m = 0.0,  // not to be trusted here
                           .search_area_m2 = width_m * width_m,
                           .any_turn = true,
                           .min_matches = kLostMinMatches});
  });
}

}  // namespace skyquilt::alignment
