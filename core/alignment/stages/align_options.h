// AlignOptions: what AlignFlight may do, and how thoroughly. A value; any thread.
#pragma once

#include <vector>

#include "core/alignment/scene/ground_control.h"
#include "core/alignment/scene/photo_set.h"

namespace skyquilt::alignment {

// Whether photos may be placed by what they show alone (attempts/attempt_by_images.h) instead of from
// recorded poses.
enum class ByImages {
  kByEvidence,  // where the records fail their test, and only if the result stands better
  kAlways,      // unless it ties fewer photos together
};

struct AlignOptions {
  int threads = 0;                    // 0 = all cores
  std::vector<ControlPoint> control;  // surveyed points marked in photos
  // Placed for good, and their lenses known; the others are placed against them. Of no photos: none is. In
  // the order of the flight, or of capture where some of it is unplaced.
  PhotoSet fixed;
  ByImages by_images = ByImages::kByEvidence;  // not asked with `fixed`
};

}  // namespace skyquilt::alignment
