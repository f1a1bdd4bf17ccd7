// MoveRepeatedPositions: a receiver that is slow, or has lost its fix, has photo after photo write the same
// position: that is one fix of the first of them. The others move on towards the next one, in even steps, and
// are as unsure as the way that was flown since; each is marked, so that it places nothing. Of each camera by
// itself; photos of one moment share their place by right. Pure; any thread.
#pragma once

#include <optional>
#include <vector>

#include "core/flight/photo.h"
#include "core/flight/remarks/remark.h"

namespace skyquilt::poses {

// `photos` in the order of capture. What to say of it; nothing where no photo repeats a position.
std::optional<flight::Remark> MoveRepeatedPositions(std::vector<flight::Photo>& photos);

}  // namespace skyquilt::poses
