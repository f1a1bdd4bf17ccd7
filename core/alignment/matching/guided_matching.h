// MatchOnGround: which keypoints of two photos may be the same thing. Both are projected to the ground first,
// so the search is a circle there; direction and size must agree, the best must stand out from the second
// best inside the circle (which refuses repetitive texture), and both sides must choose each other. Pure; any
// thread.
#pragma once

#include <complex>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/alignment/features/features.h"
#include "core/alignment/scene/view.h"

namespace skyquilt::alignment {

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

struct MatchWindow {
  double radius_m = std::numeric_limits<double>::infinity();
  double max_turn_rad = std::numeric_limits<double>::infinity();
  double max_log2_scale = 0.6;
  double max_distance_ratio = 0.85;
  int max_features = std::numeric_limits<int>::max();
};

// Half the size of two ints: a flight of thousands holds tens of millions.
struct KeypointMatch {
  std::uint16_t first = 0;   // keypoint of the first photo
  std::uint16_t second = 0;  // keypoint of the second
};
inline constexpr int kMaxKeypoints = 1 << 16;  // of a photo

inline KeypointMatch MatchOf(int first, int second) {
  return {static_cast<std::uint16_t>(first), static_cast<std::uint16_t>(second)};
}

// What a search needs of one photo.
struct GroundView {
  const PhotoFeatures* features = nullptr;
  const std::vector<GroundKeypoint>* projected = nullptr;
};

std::vector<KeypointMatch> MatchOnGround(const GroundView& first, const GroundView& second,
                                         const GroundSimilarity& second_from_first,
                                         const MatchWindow& window);

}  // namespace skyquilt::alignment
