// SceneTracks: which keypoints of several photos are one point of the scene, by the matches of verified
// pairs, the best supported pair first. A match that would put one point at two places of one photo is
// skipped, so that a wrong chain of matches loses one match, not the whole track. Pure; any thread.
#pragma once

#include <cstddef>
#include <vector>

#include "core/alignment/scene/matches.h"
#include "core/alignment/scene/registration.h"

namespace skyquilt::alignment {

struct TrackElement {
  int photo = 0;
  int keypoint = 0;
};

struct SceneTracks {
  std::vector<std::vector<TrackElement>> tracks;  // each photo at most once, in their order
  std::vector<std::vector<int>> of_photo;         // tracks a photo sees
};

SceneTracks JoinMatches(const RegistrationInput& input, const std::vector<GraphPair>& pairs);

}  // namespace skyquilt::alignment
