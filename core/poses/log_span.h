// LogSpan: from the first sample of some series to the last, on a log's clock. UsualIntervalS, AroundTime: of
// any series of samples that have a `t_s`, rising. Values; any thread.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "core/base/median.h"

namespace skyquilt::poses {

// The median interval of samples; 0 of fewer than two.
template <typename Sample>
double UsualIntervalS(const std::vector<Sample>& samples) {
  std::vector<double> intervals_s;
  for (std::size_t i = 1; i < samples.size(); ++i) intervals_s.push_back(samples[i].t_s - samples[i - 1].t_s);
  return MedianIfAny(std::move(intervals_s)).value_or(0.0);
}

// The two samples around a time and the weight of the later; the end samples hold outside. Null without.
template <typename Sample>
struct Around {
  const Sample* before = nullptr;
  const Sample* after = nullptr;
  double weight = 0.0;
  // False outside of the series, and across a hole.
  bool IsWithin(double widest_s) const { return before != after && after->t_s - before->t_s <= widest_s; }
};

template <typename Sample>
Around<Sample> AroundTime(const std::vector<Sample>& samples, double t_s) {
  if (samples.empty()) return {};
  const auto next = std::upper_bound(samples.begin(), samples.end(), t_s,
                                     [](double t, const Sample& sample) { return t < sample.t_s; });
  if (next == samples.begin()) return {&samples.front(), &samples.front(), 0.0};
  if (next == samples.end()) return {&samples.back(), &samples.back(), 0.0};
  const Sample& before = *(next - 1);
  return {&before, &*next, (t_s - before.t_s) / (next->t_s - before.t_s)};
}

struct LogSpan {
  double begin_s = std::numeric_limits<double>::infinity();
  double end_s = -std::numeric_limits<double>::infinity();
  bool IsEmpty() const { return std::isinf(begin_s); }
  bool Meets(const LogSpan& other) const { return begin_s <= other.end_s && other.begin_s <= end_s; }
  void Take(double t_s) {
    begin_s = std::min(begin_s, t_s);
    end_s = std::max(end_s, t_s);
  }
  template <typename Sample>
  void Take(const std::vector<Sample>& samples) {
    if (samples.empty()) return;
    begin_s = std::min(begin_s, samples.front().t_s);
    end_s = std::max(end_s, samples.back().t_s);
  }
};

}  // namespace skyquilt::poses
