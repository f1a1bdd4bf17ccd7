// Percentile: the value below which a share (0..1) of the values lies; one of the values, 0 for none. Takes
// them by copy, since finding it reorders them. Pure; any thread.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace skyquilt {

inline double Percentile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace skyquilt
