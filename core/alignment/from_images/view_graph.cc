#include <algorithm>
#include <iterator>
#include <map>
#include <set>

#include "core/alignment/estimators/rotation_averaging.h"
#include "core/alignment/estimators/two_view.h"
#include "core/alignment/from_images/register_photos.h"
#include "core/alignment/matching/match_descriptors.h"
#include "core/alignment/matching/pair_sources.h"
#include "core/base/median.h"
#include "core/base/parallel_for.h"

namespace skyquilt::alignment {
namespace {

constexpr int kFeatures = 800;         // compared first
constexpr int kFeaturesOfWeak = 2000;  // of photos that are left with very few partners
constexpr int kEnoughPartners = 6;     // photos with fewer are compared with more
constexpr int kFewPartners = 3;
constexpr double kMinRefusedRad = 0.21;  // 12 degrees: flat ground seen from nearby leaves a tilt open
constexpr double kRefusedMedians = 6.0;
constexpr int kMaxThroughOthers = 4;  // pairs of a photo that share a neighbour

using Pair = std::pair<int, int>;

class Verifier {
 public:
  Verifier(Registration& input, int threads)
      : input_(input), threads_(threads), rays_(RaysOf(input, kFeaturesOfWeak, threads)) {}

  // Compares and verifies; adds what was found to the view graph.
  void Compare(const std::vector<Pair>& pairs, int features) {
    std::vector<PhotoPair> compared(pairs.size());
    ParallelFor(pairs.size(), threads_, [&](std::size_t p) {
      const auto [first, second] = pairs[p];
      compared[p] = {first, second, {}, MatchDescriptors(FeaturesOf(first), FeaturesOf(second), features)};
    });
    std::erase_if(compared, [](const PhotoPair& pair) { return pair.matches.size() < kMinTwoViewMatches; });
    Verify(compared);
    for (PhotoPair& pair : compared) input_.compared.push_back(std::move(pair));
    input_.pairs_compared += static_cast<int>(pairs.size());
  }

  void Verify(const std::vector<PhotoPair>& compared) {
    const auto verify = [&](std::size_t p) { return VerifyTwoViews(input_, rays_, compared[p]); };
    std::vector<PhotoPair> found = ParallelCollect(compared.size(), threads_, verify);
    std::move(found.begin(), found.end(), std::back_inserter(input_.links));
  }

 private:
  const PhotoFeatures& FeaturesOf(int i) const { return *input_.features[i]; }

  Registration& input_;
  int threads_;
  KeypointRays rays_;
};

PhotoSet WithFewerPartners(const Registration& input, int enough) {
  const std::vector<int> partners = CountPairs(input.Photos(), input.links);
  PhotoSet fewer;
  for (std::size_t i = 0; i < partners.size(); ++i) fewer.Append(input.features[i] && partners[i] < enough);
  return fewer;
}

// Two photos that both show what a third one shows, the best supported first.
std::vector<Pair> ThroughOthers(int photos, const std::vector<PhotoPair>& pairs,
                                const std::set<Pair>& tried) {
  std::vector<std::map<int, double>> neighbours(photos);
  for (const PhotoPair& pair : pairs) {
    const auto support = static_cast<double>(pair.matches.size());
    neighbours[pair.first][pair.second] = support;
    neighbours[pair.second][pair.first] = support;
  }
  std::vector<std::pair<double, Pair>> ranked;
  for (int i = 0; i < photos; ++i) {
    std::map<int, double> through;
    for (const auto& [middle, support] : neighbours[i]) {
      for (const auto& [other, of_other] : neighbours[middle]) {
        if (other > i && !tried.contains({i, other})) through[other] += std::min(support, of_other);
      }
    }
    for (const auto& [other, support] : through) ranked.emplace_back(-support, Pair{i, other});
  }
  std::sort(ranked.begin(), ranked.end());
  std::vector<int> taken(photos, 0);
  std::vector<Pair> chosen;
  for (const auto& [support, pair] : ranked) {
    int& first = taken[pair.first];
    int& second = taken[pair.second];
    if (first >= kMaxThroughOthers || second >= kMaxThroughOthers) continue;
    ++first;
    ++second;
    chosen.push_back(pair);
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

void SortOnce(std::vector<PhotoPair>& pairs) {
  std::sort(pairs.begin(), pairs.end(), [](const PhotoPair& a, const PhotoPair& b) {
    return std::pair(a.first, a.second) < std::pair(b.first, b.second);
  });
  // A pair that was compared twice, with all features the second time: the better.
  std::vector<PhotoPair> once;
  for (PhotoPair& pair : pairs) {
    if (once.empty() || once.back().first != pair.first || once.back().second != pair.second) {
      once.push_back(std::move(pair));
    } else if (pair.matches.size() > once.back().matches.size()) {
      once.back() = std::move(pair);
    }
  }
  pairs = std::move(once);
}

// Each pair once, in order, its pose by what the others say; and out with those that have none.
void AgreeOnRotations(Registration& input) {
  const int photos = static_cast<int>(input.Photos());
  SortOnce(input.links);
  input.pairs_verified = static_cast<int>(input.links.size());
  input.pairs_refused = 0;
  AveragedRotations averaged = AverageRotations(photos, input.links);
  bool is_changed = false;
  for (PhotoPair& pair : input.links) {
    if (pair.poses.size() < 2) continue;
    const Eigen::Quaterniond expected =
        averaged.cam_from_world[pair.second] * averaged.cam_from_world[pair.first].conjugate();
    if (expected.angularDistance(pair.poses[1].rotation) < expected.angularDistance(pair.poses[0].rotation)) {
      std::swap(pair.poses[0], pair.poses[1]);
      is_changed = true;
    }
  }
  if (is_changed) averaged = AverageRotations(photos, input.links);
  if (input.links.empty()) return;
  const double refused_rad = std::max(kMinRefusedRad, kRefusedMedians * Median(averaged.residual_rad));
  std::size_t p = 0;
  input.pairs_refused = static_cast<int>(std::erase_if(
      input.links, [&](const PhotoPair&) { return !(averaged.residual_rad[p++] <= refused_rad); }));
}

}  // namespace

void BuildViewGraph(int threads, Progress& progress, Registration& input) {
  const int count = static_cast<int>(input.Photos());
  const Appearance appearance = Appearance::Learn(input.features, threads);
  Verifier verifier(input, threads);
  const std::vector<Pair> candidates = CandidatePairs({input, appearance, {}, {}, threads});
  verifier.Compare(candidates, kFeatures);
  std::set<Pair> tried(candidates.begin(), candidates.end());
  for (const bool is_last : {false, true}) {
    if (progress.IsCancelled()) break;
    const PhotoSet wanted = WithFewerPartners(input, is_last ? kFewPartners : kEnoughPartners);
    if (wanted.Count() == 0) break;
    std::vector<Pair> more =
        CandidatePairs({input, appearance, CandidateOptions::Generous(), wanted, threads});
    // The last time all of their features are compared, also with those that did not agree by the first.
    std::set<Pair> done;
    for (const PhotoPair& pair : input.links) done.emplace(pair.first, pair.second);
    std::erase_if(
        more, [&](const Pair& pair) { return done.contains(pair) || (!is_last && tried.contains(pair)); });
    verifier.Compare(more, is_last ? kFeaturesOfWeak : kFeatures);
    tried.insert(more.begin(), more.end());
  }
  if (!progress.IsCancelled()) verifier.Compare(ThroughOthers(count, input.links, tried), kFeatures);
  AgreeOnRotations(input);
}

void VerifyAgain(int threads, Registration& input) {
  input.links.clear();
  Verifier(input, threads).Verify(input.compared);
  AgreeOnRotations(input);
}

}  // namespace skyquilt::alignment
