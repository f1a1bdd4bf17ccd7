// FindConnectedComponents: the connected components of the view graph. What lies in two
// components is only as right to each other as the records are. Pure; any thread.
#pragma once

#include <cstddef>
#include <vector>

#include "core/alignment/scene/matches.h"

namespace skyquilt::alignment {

struct ConnectedComponents {
  std::vector<int> of_photo;              // negative: no verified pair
  std::vector<std::vector<int>> members;  // by component, in the photos' order
};

ConnectedComponents FindConnectedComponents(std::size_t photos, const std::vector<VerifiedPair>& pairs);

}  // namespace skyquilt::alignment
