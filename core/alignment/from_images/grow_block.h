// A block of photos from nothing: two that see a scene from different places, then all others that see enough
// of the points so far, adjusted again and again while it grows. What two views of flat ground leave open the
// next photos decide: several initial pairs are tried and the one with most inliers is taken. The same for
// any number of threads.
#pragma once

#include <cstddef>
#include <optional>
#include <set>
#include <vector>

#include "core/alignment/estimators/absolute_pose.h"
#include "core/alignment/from_images/block.h"
#include "core/alignment/scene/photo_set.h"
#include "core/alignment/scene/priors.h"
#include "core/base/progress.h"

namespace skyquilt::alignment {

// Of photos that `used` leaves, by two that `spent` leaves as well; nothing when no two of those begin a
// block of three or more. `failed`: links that began none, which are remembered while the lenses stay.
std::optional<Block> BeginBlock(const Registration& input, const std::vector<BundleLens>& lenses,
                                const PhotoSet& used, const PhotoSet& spent, int threads,
                                std::set<std::size_t>& failed, const Progress& progress);

// Takes in photos that `used` leaves until no more follow. The block is adjusted as a whole at the end. Where
// no photo sees enough of the points, one that shows what placed ones show is taken in over the ground, and
// the others follow it.
void GrowBlock(const PhotoSet& used, int threads, Progress& progress, Block& block);

// Where a photo was taken that shares verified matches with placed photos but hardly any of their points,
// because nothing is seen by three of them (a line of photos that overlap by half): what the matches show in
// the placed photos is projected to the ground below these. The scale then comes from the ground's being
// level there, the place from resection. Only where two placed photos agree, or one by many matches. The best
// supported first. `left_out`: photos that are not asked for.
std::vector<FoundPose> ResectOverGround(const Block& block, const PhotoSet& left_out, int threads);

}  // namespace skyquilt::alignment
