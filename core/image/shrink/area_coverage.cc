#include "core/image/shrink/area_coverage.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace skyquilt::image {

std::vector<AreaCoverage> AreaCoverageOf(int from_px, int to_px) {
  std::vector<AreaCoverage> coverage(static_cast<std::size_t>(to_px));
  const double step = static_cast<double>(from_px) / to_px;
  for (int i = 0; i < to_px; ++i) {
    const double begin = i * step;
    const double end = std::min<double>(from_px, (i + 1) * step);
    AreaCoverage& one = coverage[static_cast<std::size_t>(i)];
    one.first = static_cast<int>(begin);
    one.last = std::max(one.first, static_cast<int>(std::ceil(end)) - 1);
    one.of_first = std::min<double>(one.first + 1, end) - begin;
    one.of_last = end - one.last;
  }
  return coverage;
}

}  // namespace skyquilt::image
