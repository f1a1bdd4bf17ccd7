// What two photos share: matched keypoints, and the motion that they agree on, over the ground (between poses
// that are known) or between two cameras of which nothing is known; what photos have such pairs, and the way
// along the strongest. Values; any thread.
#pragma once

#include <Eigen/Core>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <queue>
#include <utility>
#include <vector>

#include "core/alignment/scene/photo_set.h"
#include "core/geo/rigid3.h"

namespace skyquilt::alignment {

// A keypoint of the first photo and one of the second. Half the size of two ints: a flight of thousands holds
// tens of millions.
using KeypointMatch = std::pair<std::uint16_t, std::uint16_t>;
inline constexpr int kMaxKeypoints = 1 << 16;  // of a photo

// One place as two photos show it: rays (x, y, 1) of both, or pixels.
using RayPair = std::pair<Eigen::Vector2d, Eigen::Vector2d>;

// z -> turn_and_scale * z + shift on the ground, E + iN.
struct GroundSimilarity {
  std::complex<double> turn_and_scale{1.0, 0.0};
  std::complex<double> shift{0.0, 0.0};

  std::complex<double> operator*(std::complex<double> z) const { return turn_and_scale * z + shift; }
  GroundSimilarity Inverse() const { return {1.0 / turn_and_scale, -shift / turn_and_scale}; }
  // Maps by `first` and then by this one.
  GroundSimilarity After(const GroundSimilarity& first) const {
    return {turn_and_scale * first.turn_and_scale, turn_and_scale * first.shift + shift};
  }
};

// What two photos show of each other: what looks the same in both and, once that is verified, the motion over
// the ground between their poses, or without any record the geometry of two views.
struct PhotoPair {
  int first = 0, second = 0;
  GroundSimilarity second_from_first = {};
  std::vector<KeypointMatch> matches = {};  // all; once verified, those that fit
  double rms_m = 0.0;                       // of that motion
  // second_from_first, the length of the shift unknown (1, or 0 without parallax); empty: not verified. The
  // likeliest first, or the one that the loops agree with; a second where the matches fit it nearly as well.
  std::vector<geo::Rigid3> poses = {};
  double angle_rad = 0.0;  // between two rays to the same point, in the median
  // Of a candidate: share of the one's picture that the other sees; of unlike ones the wider's.
  double overlap = 0.0;
};

// By photo, of how many of the pairs it is one.
inline std::vector<int> CountPairs(std::size_t photos, const std::vector<PhotoPair>& pairs) {
  std::vector<int> counts(photos, 0);
  for (const PhotoPair& pair : pairs) ++counts[pair.first], ++counts[pair.second];
  return counts;
}

// From `roots` outwards along the strongest pairs, of equals the earlier: `place(pair, from, to)` once for
// each other photo that is reached. of_photo: the numbers of its pairs.
template <typename Strength, typename Place>
void FollowStrongest(const std::vector<PhotoPair>& pairs, const std::vector<std::vector<int>>& of_photo,
                     const std::vector<int>& roots, const Strength& strength, const Place& place) {
  PhotoSet placed(of_photo.size());
  std::priority_queue<std::pair<double, int>> open;  // strength, minus the pair's number
  const auto open_pairs = [&](int photo) {
    for (const int p : of_photo[photo]) open.emplace(strength(pairs[p]), -p);
  };
  for (const int root : roots) placed.Add(root);
  for (const int root : roots) open_pairs(root);
  while (!open.empty()) {
    const PhotoPair& pair = pairs[-open.top().second];
    open.pop();
    const bool forth = placed.Has(pair.first);
    const int from = forth ? pair.first : pair.second, to = forth ? pair.second : pair.first;
    if (placed.Has(to)) continue;
    place(pair, from, to);
    placed.Add(to);
    open_pairs(to);
  }
}

}  // namespace skyquilt::alignment
