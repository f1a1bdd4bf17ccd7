// What the comparisons with libraries measure by: the calling thread's processor time, numbers that repeat,
// quantiles.
#pragma once

#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "core/alignment/estimators/sampler.h"

namespace skyquilt::alignment {

inline double ThreadSeconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// In [0, 1).
inline double Uniform(Sampler& sampler) { return static_cast<double>(sampler.Next() >> 11) * 0x1.0p-53; }

// Normally distributed, sigma 1 (Box and Muller).
inline double Gaussian(Sampler& sampler) {
  const double radius = std::sqrt(-2.0 * std::log(1.0 - Uniform(sampler)));
  return radius * std::cos(2.0 * std::numbers::pi * Uniform(sampler));
}

// Precondition: non-empty.
inline double Quantile(std::vector<double> values, double share) {
  const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

}  // namespace skyquilt::alignment
