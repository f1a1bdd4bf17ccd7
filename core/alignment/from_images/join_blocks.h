// JoinBlocks: a smaller block moved into the frame of a larger one by the points that both see, where enough
// of them agree on one similarity. Deterministic. Pure; any thread.
#pragma once

#include "core/alignment/estimators/similarity.h"
#include "core/alignment/from_images/block.h"

namespace skyquilt::alignment {

// larger_from_smaller; nothing when too few points agree.
std::optional<Similarity3> FindJoint(const Block& larger, const Block& smaller);

// Takes the smaller one's photos over.
void JoinBlocks(const Similarity3& larger_from_smaller, const Block& smaller, int threads, Block& larger);

}  // namespace skyquilt::alignment
