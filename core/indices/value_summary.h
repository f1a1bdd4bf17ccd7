// ValueSummary: what an index comes to over an area: least, greatest, mean, spread, percentiles, a histogram;
// and the bounds between classes of equal size. Of finite values; takes them by move, since finding
// percentiles reorders them. Memory: the values. Pure; any thread.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace skyquilt::indices {

struct ValueSummary {
  static constexpr std::array kPercents = {2, 5, 10, 25, 50, 75, 90, 95, 98};
  static constexpr int kBins = 64;

  std::int64_t count = 0;  // all else is zero where this is
  double min = 0.0, max = 0.0, mean = 0.0, std = 0.0;
  std::array<double, kPercents.size()> percentiles{};
  std::array<std::int64_t, kBins> histogram{};  // of bins of one width from min to max
};
ValueSummary Summarise(std::vector<float> values);

// The `classes` - 1 values that part them into classes of as many each, ascending; fewer where values repeat
// so often that two would be the same. Precondition: classes >= 1.
std::vector<double> QuantileBreaks(std::vector<float> values, int classes);
// The class of a value, from 0: how many of the breaks are not above it.
int ClassOf(double value, const std::vector<double>& breaks);

}  // namespace skyquilt::indices
