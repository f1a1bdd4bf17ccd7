#include "core/indices/value_summary.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace skyquilt::indices {
namespace {

// Between the two nearest values, as numpy's default has it. `from`: what lies below is smaller already.
double Quantile(std::vector<float>& values, double share, std::size_t from) {
  const double place = share * static_cast<double>(values.size() - 1);
  const auto below = std::max(static_cast<std::size_t>(place), from);
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(below);
  std::nth_element(values.begin() + static_cast<std::ptrdiff_t>(from), at, values.end());
  const double fraction = place - std::floor(place);
  if (fraction == 0.0 || at + 1 == values.end()) return *at;
  const double above = *std::min_element(at + 1, values.end());
  return *at + (above - *at) * fraction;
}

}  // namespace

ValueSummary Summarise(std::vector<float> values) {
  ValueSummary summary;
  summary.count = static_cast<std::int64_t>(values.size());
  if (values.empty()) return summary;
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  summary.min = *least;
  summary.max = *most;
  double sum = 0.0;
  for (const float value : values) sum += value;
  summary.mean = sum / static_cast<double>(values.size());
  double squares = 0.0;
  const double bins_per_unit = summary.max > summary.min ? summary.kBins / (summary.max - summary.min) : 0.0;
  for (const float value : values) {
    squares += (value - summary.mean) * (value - summary.mean);
    const auto bin = static_cast<int>((value - summary.min) * bins_per_unit);
    ++summary.histogram[static_cast<std::size_t>(std::clamp(bin, 0, ValueSummary::kBins - 1))];
  }
  summary.std = std::sqrt(squares / static_cast<double>(values.size()));
  std::size_t sorted_to = 0;
  for (std::size_t i = 0; i < summary.kPercents.size(); ++i) {
    const double share = ValueSummary::kPercents[i] / 100.0;
    summary.percentiles[i] = Quantile(values, share, sorted_to);
    sorted_to = static_cast<std::size_t>(share * static_cast<double>(values.size() - 1));
  }
  return summary;
}

std::vector<double> QuantileBreaks(std::vector<float> values, int classes) {
  std::vector<double> breaks;
  if (values.empty()) return breaks;
  const double least = *std::min_element(values.begin(), values.end());
  for (int i = 1; i < classes; ++i) {
    const double at = Quantile(values, static_cast<double>(i) / classes, 0);
    if (at > least && (breaks.empty() || at > breaks.back())) breaks.push_back(at);
  }
  return breaks;
}

int ClassOf(double value, const std::vector<double>& breaks) {
  return static_cast<int>(std::upper_bound(breaks.begin(), breaks.end(), value) - breaks.begin());
}

}  // namespace skyquilt::indices
