// MatchDescriptors: which keypoints of two photos look the same, wherever they lie in the picture: each
// other's nearest descriptors, and nearer by a ratio than the next one at another place (D. Lowe, IJCV 2004).
// Exact sums of integers. Cost: the product of the two counts. Pure; any thread.
#pragma once

#include <vector>

#include "core/alignment/scene/keypoints.h"
#include "core/alignment/scene/matches.h"

namespace skyquilt::alignment {

// In the order of the first photo's keypoints. max_features: of each photo; any first n are spread over it.
std::vector<KeypointMatch> MatchDescriptors(const PhotoFeatures& first, const PhotoFeatures& second,
                                            int max_features = 1000);

}  // namespace skyquilt::alignment
