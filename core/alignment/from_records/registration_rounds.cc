#include "core/alignment/from_records/registration_rounds.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/alignment/from_records/bundle_setup.h"
#include "core/alignment/from_records/correct_poses.h"
#include "core/alignment/from_records/register_by_resection.h"
#include "core/alignment/matching/connected_components.h"
#include "core/base/median.h"

namespace skyquilt::alignment {
namespace {

constexpr int kMaxRegistrationRounds = 4;
constexpr std::size_t kSmallComponent = 5;  // of photos, which hold each other but not where they all are

// By enough points, and not only to a few others apart from the rest.
std::vector<char> TiedPhotos(const BundleProblem& problem, const std::vector<VerifiedPair>& links) {
  std::vector<int> seen(problem.photos.size(), 0);
  for (const Track& track : problem.tracks) {
    for (const Observation& one : track.observations) ++seen[one.photo];
  }
  std::vector<char> tied(seen.size());
  for (std::size_t i = 0; i < seen.size(); ++i) tied[i] = seen[i] >= kEnoughObservations ? 1 : 0;
  const ConnectedComponents components = FindConnectedComponents(seen.size(), links);
  std::size_t largest = 0;
  for (const std::vector<int>& members : components.members) largest = std::max(largest, members.size());
  for (const std::vector<int>& members : components.members) {
    if (members.size() > kSmallComponent || 2 * members.size() > largest) continue;
    for (const int i : members) tied[i] = 0;
  }
  return tied;
}

// How far the tied photos moved on the ground against their records: what must be expected of the others. At
// least one is tied.
double ExpectedErrorM(const poses::PosedFlight& posed, const BundleProblem& problem,
                      const std::vector<GroundPrior>& recorded, const std::vector<char>& tied) {
  std::vector<double> moved_m, recorded_m;
  for (std::size_t i = 0; i < tied.size(); ++i) {
    recorded_m.push_back(recorded[i].sigma_m);
    if (!tied[i]) continue;
    moved_m.push_back(
        std::abs(GroundMotion(posed.photos[i], recorded[i], problem.photos[i].cam_from_enu).shift));
  }
  const double of_records_m = Median(recorded_m);
  return std::max(of_records_m, Median(moved_m));
}

}  // namespace

int RegisterInRounds(const poses::PosedFlight& posed, const Relief& relief, int threads, MatchingInput& input,
                     MatchedFlight& linked, BundleProblem& problem) {
  std::vector<char> tied = TiedPhotos(problem, linked.links);
  if (std::count(tied.begin(), tied.end(), 1) == 0 || std::count(tied.begin(), tied.end(), 0) == 0) return 0;
  const std::vector<GroundPrior> recorded = MakeGroundPriors(posed, MakeMatchingInput(posed));
  const double expected_m = ExpectedErrorM(posed, problem, recorded, tied);
  int resected = 0;
  for (int round = 0; round < kMaxRegistrationRounds; ++round) {
    const std::vector<ResectedPhoto> found = RegisterByResection(input, relief, tied, expected_m, threads);
    if (found.empty()) break;
    for (const ResectedPhoto& one : found) {
      const int i = one.photo;
      linked.corrected[i] = CorrectToPose(posed.photos[i], recorded[i], one.cam_from_enu);
      problem.photos[i] = MakeBundlePhoto(posed.photos[i], linked.corrected[i], problem.photos[i].lens,
                                          problem.photos[i].line);
      input.views[i].cam_from_enu = one.cam_from_enu;
      std::erase_if(linked.links,
                    [&](const VerifiedPair& link) { return link.first == i || link.second == i; });
      linked.links.insert(linked.links.end(), one.links.begin(), one.links.end());
      tied[i] = 1;
    }
    resected += static_cast<int>(found.size());
  }
  return resected;
}

}  // namespace skyquilt::alignment
