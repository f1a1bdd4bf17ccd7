// MatchOnGround: which keypoints of two photos may be the same thing. Both are projected to the ground first,
// so the search is a circle there; direction and size must agree, the best must stand out from the second
// best inside the circle (which refuses repetitive texture), and both sides must choose each other. Pure; any
// thread.
#pragma once

#include <limits>
#include <vector>

#include "core/alignment/scene/keypoints.h"
#include "core/alignment/scene/matches.h"
#include "core/alignment/scene/view.h"

namespace skyquilt::alignment {

struct MatchWindow {
  double radius_m = std::numeric_limits<double>::infinity();
  double max_turn_rad = std::numeric_limits<double>::infinity();
  double max_distance_ratio = 0.85;
  int max_features = std::numeric_limits<int>::max();
};

std::vector<KeypointMatch> MatchOnGround(const std::vector<const PhotoFeatures*>& features,
                                         const GroundKeypoints& projected, int first, int second,
                                         const MatchWindow& window);

}  // namespace skyquilt::alignment
