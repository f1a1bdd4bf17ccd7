// AreaCoverage: what of the pixels of one direction each pixel of a smaller picture covers, by which areas
// are averaged. Pure.
#pragma once

#include <vector>

namespace skyquilt::image {

struct AreaCoverage {
  int first = 0, last = 0;               // pixels of the larger picture
  double of_first = 0.0, of_last = 0.0;  // how much of these two is covered; of those between, all

  double Of(int at) const { return at == first ? of_first : at == last ? of_last : 1.0; }
};

// By pixel of the smaller picture; 1 <= to_px <= from_px.
std::vector<AreaCoverage> AreaCoverageOf(int from_px, int to_px);

}  // namespace skyquilt::image
