// FindReadout: how long cameras took to read their rows, of which no record says that they read rows at all,
// where the photos show it: the aircraft flew on meanwhile, so that photos taken across or against each
// other's course are stretched against each other, which no pose and no lens explains. Photos taken all alike
// are stretched alike and show nothing. Frame `enu`. Pure; any thread. Source of the model:
// core/camera/rolling_shutter.h.
#pragma once

#include <vector>

#include "core/alignment/bundle/bundle_adjustment.h"
#include "core/alignment/scene/photo_set.h"

namespace skyquilt::alignment {

// Lenses of an adjusted problem whose observations are off by the rows they lie in, as photos that were read
// while the camera flew would be: worth an adjustment with finds_readout. The cost is that of one evaluation.
// may_roll: photos of which nothing is known of how they were read.
std::vector<int> LensesThatMayRoll(const BundleProblem& adjusted, const PhotoSet& may_roll);

// Of those lenses in `adjusted`, a problem adjusted with finds_readout, the ones whose readout is as long as
// cameras take and explains their observations far better than none.
std::vector<int> LensesThatRoll(const BundleProblem& adjusted, const std::vector<int>& lenses);

}  // namespace skyquilt::alignment
