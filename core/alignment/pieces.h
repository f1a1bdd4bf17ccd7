// FindPieces: the photos that links hold together, directly or through others. What lies in two pieces is
// only as right to each other as the records are. Pure; any thread.
#pragma once

#include <cstddef>
#include <vector>

#include "core/alignment/pair_link.h"

namespace skyquilt::alignment {

struct Pieces {
  std::vector<int> of_photo;              // negative: no link at all
  std::vector<std::vector<int>> members;  // by piece, in the photos' order
};

Pieces FindPieces(std::size_t photos, const std::vector<PairLink>& links);

}  // namespace skyquilt::alignment
