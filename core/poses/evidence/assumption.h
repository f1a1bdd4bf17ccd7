// Assumption: what poses are estimated with where nothing is recorded. The map rests on it only as far as
// poses alone place the photos; photos that are aligned have the value found. Values; any thread.
#pragma once

#include <optional>
#include <vector>

#include "core/flight/remarks/remark.h"

namespace skyquilt::poses {

struct Assumption {
  flight::Remark missing;                       // what no record tells
  flight::Remark assumed;                       // what is taken instead
  std::optional<double> height_above_ground_m;  // that is assumed; nothing: the assumption is of angles
};

// Where poses alone place the photos.
std::vector<flight::Remark> AssumptionsByPoses(const std::vector<Assumption>& assumptions);

// Where photos are aligned: `found_height_m` above ground in the median, `by_pose` of them by poses alone.
std::vector<flight::Remark> AssumptionsAfterAlignment(const std::vector<Assumption>& assumptions,
                                                      double found_height_m, int by_pose);

}  // namespace skyquilt::poses
