#include "core/alignment/from_images/join_blocks.h"

#include <algorithm>
#include <cmath>

#include "core/alignment/estimators/sampler.h"

namespace skyquilt::alignment {
namespace {

constexpr int kMinShared = 12;
constexpr int kJoinSamples = 300;
constexpr double kToleranceShare = 0.02;  // of the depth
constexpr double kMinShareHeld = 0.3;

}  // namespace

std::optional<Similarity3> FindJoint(const Block& larger, const Block& smaller) {
  std::vector<PlacePair> shared;
  for (std::size_t t = 0; t < larger.scene().tracks.size(); ++t) {
    const int track = static_cast<int>(t);
    if (larger.HasPoint(track) && smaller.HasPoint(track)) {
      shared.push_back({smaller.Point(track), larger.Point(track), Eigen::Vector3d::Ones()});
    }
  }
  const int count = static_cast<int>(shared.size());
  if (count < kMinShared) return std::nullopt;
  const double tolerance = kToleranceShare * kMedianDepth;
  Sampler sampler(static_cast<std::uint64_t>(count));
  std::vector<PlacePair> most;
  for (int s = 0; s < kJoinSamples; ++s) {
    std::vector<PlacePair> three;
    for (const int k : sampler.Distinct<3>(count)) three.push_back(shared[k]);
    std::optional<Similarity3> proposed = FitSimilarity3(three);
    for (int round = 0; proposed && round < 3; ++round) {
      std::vector<PlacePair> held;
      for (const PlacePair& pair : shared) {
        if ((*proposed * pair.in_source - pair.in_target).norm() < tolerance) held.push_back(pair);
      }
      if (held.size() <= most.size()) break;
      proposed = FitSimilarity3(held);
      most = std::move(held);
    }
  }
  if (static_cast<int>(most.size()) < kMinShared ||
      static_cast<double>(most.size()) < kMinShareHeld * count) {
    return std::nullopt;
  }
  return FitSimilarity3(most);
}

void JoinBlocks(const Similarity3& larger_from_smaller, const Block& smaller, int threads, Block& larger) {
  std::vector<int> taken;
  for (std::size_t i = 0; i < smaller.input().photos.size(); ++i) {
    const int photo = static_cast<int>(i);
    if (!smaller.Has(photo) || larger.Has(photo)) continue;
    larger.Place(photo, larger_from_smaller.Moved(smaller.Pose(photo)));
    taken.push_back(photo);
  }
  larger.TriangulateSeenBy(taken, threads);
}

}  // namespace skyquilt::alignment
