// ResectOverGround: where a photo was taken that shares verified matches with placed photos but hardly any of
// their points, because nothing is seen by three of them (a line of photos that overlap by half): what the
// matches show in the placed photos is projected to the ground below these. The scale then comes from the
// ground's being level there, the place from resection. Only where two placed photos agree, or one by many
// matches. Deterministic. Pure; any thread.
#pragma once

#include <vector>

#include "core/alignment/from_images/block.h"
#include "core/alignment/scene/matches.h"
#include "core/alignment/scene/photo_set.h"

namespace skyquilt::alignment {

struct GroundedPose {
  int photo = 0;
  geo::Rigid3 cam_from_world;
  int agreeing = 0;  // matches
};

// `pairs`: of the whole graph. `left_out`: photos that are not asked for. The best supported first.
std::vector<GroundedPose> ResectOverGround(const Block& block, const std::vector<GraphPair>& pairs,
                                           const PhotoSet& left_out, int threads);

}  // namespace skyquilt::alignment
