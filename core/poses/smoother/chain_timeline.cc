#include "core/poses/smoother/chain_timeline.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"

namespace skyquilt::poses {
namespace {
constexpr double kSameTimeS = 1.0e-4;
}

ChainTimeline::ChainTimeline(double begin_s, double end_s, const std::vector<double>& fixed_times,
                             double spacing_s) {
  SKYQUILT_CHECK(spacing_s > 0.0 && end_s >= begin_s, "a chain needs a positive spacing and a rising span");
  times_.push_back(begin_s);
  const auto reach = [&](double t) {
    const double gap = t - times_.back();
    if (gap <= kSameTimeS) return;
    const int parts = std::max(1, static_cast<int>(std::ceil(gap / spacing_s - 1e-9)));
    const double from = times_.back();
    for (int k = 1; k < parts; ++k) times_.push_back(from + gap * k / parts);
    times_.push_back(t);
  };
  for (const double t : fixed_times) reach(t);
  reach(end_s);
}

double ChainTimeline::Duration(int interval) const {
  const auto i = static_cast<std::size_t>(interval);
  return times_[i + 1] - times_[i];
}

std::optional<TimePlace> ChainTimeline::Place(double t_s) const {
  if (t_s < times_.front() - kSameTimeS || t_s > times_.back() + kSameTimeS) return std::nullopt;
  const int nearest = Nearest(t_s);
  if (std::abs(times_[static_cast<std::size_t>(nearest)] - t_s) <= kSameTimeS) return TimePlace{nearest, 0.0};
  const auto next = std::upper_bound(times_.begin(), times_.end(), t_s);
  const int knot = static_cast<int>(next - times_.begin()) - 1;
  return TimePlace{knot, (t_s - times_[static_cast<std::size_t>(knot)]) / Duration(knot)};
}

int ChainTimeline::Nearest(double t_s) const {
  const auto next = std::lower_bound(times_.begin(), times_.end(), t_s);
  if (next == times_.begin()) return 0;
  if (next == times_.end()) return size() - 1;
  const auto index = static_cast<int>(next - times_.begin());
  return *next - t_s < t_s - *(next - 1) ? index : index - 1;
}

}  // namespace skyquilt::poses
