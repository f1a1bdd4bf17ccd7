// KeypointSets: the keypoints of all photos under running numbers, and which of them are one point by the
// matches joined so far (disjoint sets; the smallest number stands for its set). One thread.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <vector>

#include "core/alignment/scene/keypoints.h"

namespace skyquilt::alignment {

// Sizes up to this many sigmas are located alike.
inline constexpr double kFineScales = 60.0;

// How much worse than the photo's finest a keypoint is located that stands for a large patch.
inline double KeypointCoarseness(const PhotoFeatures& features, int keypoint) {
  const double size = features.keypoints[keypoint].scale_px;
  return std::max(1.0, size / (features.sigma_px * kFineScales));
}
inline double KeypointSigmaPx(const PhotoFeatures& features, int keypoint) {
  return features.sigma_px * KeypointCoarseness(features, keypoint);
}

// Two keypoints of one photo that describe one place in two directions.
inline bool IsOnePlace(const PhotoFeatures& features, int a, int b) {
  const Keypoint& x = features.keypoints[a];
  const Keypoint& y = features.keypoints[b];
  return std::hypot(x.x_px - y.x_px, x.y_px - y.y_px) <= 1.0F;
}

class KeypointSets {
 public:
  // By photo; null: it has none.
  explicit KeypointSets(const std::vector<const PhotoFeatures*>& features) : first_of_{0} {
    for (const PhotoFeatures* one : features) {
      first_of_.push_back(first_of_.back() + (one ? static_cast<int>(one->keypoints.size()) : 0));
    }
    root_.resize(first_of_.back());
    std::iota(root_.begin(), root_.end(), 0);
  }

  std::size_t size() const { return root_.size(); }
  int NumberOf(std::size_t photo, int keypoint) const { return first_of_[photo] + keypoint; }

  int Find(int number) {
    while (root_[number] != number) {
      int& up = root_[number];
      number = up = root_[up];
    }
    return number;
  }
  // Two sets by what stands for them.
  void Join(int a, int b) { root_[std::max(a, b)] = std::min(a, b); }

 private:
  std::vector<int> first_of_, root_;
};

}  // namespace skyquilt::alignment
