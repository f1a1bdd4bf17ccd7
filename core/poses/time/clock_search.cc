#include "core/poses/time/clock_search.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "core/base/median.h"

namespace skyquilt::poses {
namespace {

constexpr double kLongestGapS = 2.0;
constexpr double kCoarseStepS = 0.5;
constexpr std::size_t kMaxSteps = 200'000;
constexpr std::size_t kMaxPhotosCoarse = 150;

// Errors of all photos at an offset (infinite where off the track).
using ErrorsAt = std::function<void(double offset_s, std::size_t stride, std::vector<double>& errors)>;

// Cauchy cost per photo; those off the track cost as much as a gross error. A metre is a receiver's noise.
double CostOf(const std::vector<double>& errors) {
  double sum = 0.0;
  for (const double error : errors) {
    const double z = std::isfinite(error) ? error : 100.0;
    sum += std::log1p(std::min(z * z, 1e4));
  }
  return sum / static_cast<double>(errors.size());
}

struct Range {
  double from_s;
  double to_s;
};

std::optional<ClockOffset> Search(const ErrorsAt& errors_at, std::size_t count, Range range) {
  if (!(range.to_s >= range.from_s)) return std::nullopt;
  const double step = std::max(kCoarseStepS, (range.to_s - range.from_s) / static_cast<double>(kMaxSteps));
  const std::size_t stride = std::max<std::size_t>(1, count / kMaxPhotosCoarse);
  const auto steps = static_cast<std::size_t>((range.to_s - range.from_s) / step) + 1;
  std::vector<double> errors;
  std::vector<double> costs(steps);
  for (std::size_t k = 0; k < steps; ++k) {
    errors_at(range.from_s + step * static_cast<double>(k), stride, errors);
    costs[k] = CostOf(errors);
  }
  const auto best = static_cast<std::size_t>(std::min_element(costs.begin(), costs.end()) - costs.begin());
  ClockOffset found;
  // Narrowing grids around the minimum.
  double middle = range.from_s + step * static_cast<double>(best);
  double reach = 2.0 * step;
  while (reach > 2e-3) {
    double at = middle;
    double lowest = std::numeric_limits<double>::infinity();
    for (int k = -10; k <= 10; ++k) {
      const double offset = middle + reach * k / 10.0;
      errors_at(offset, 1, errors);
      const double cost = CostOf(errors);
      if (cost < lowest) {
        lowest = cost;
        at = offset;
      }
    }
    middle = at;
    reach *= 0.2;
  }
  found.offset_s = middle;
  errors_at(middle, 1, errors);
  std::vector<double> sizes;
  for (const double error : errors) {
    if (std::isfinite(error)) sizes.push_back(std::abs(error));
  }
  if (sizes.empty()) return std::nullopt;
  found.residual_m = Median(sizes);
  return found;
}

}  // namespace

std::optional<Eigen::Vector2d> TrackAt(std::span<const TrackPoint> track, double t_s) {
  const auto after = std::lower_bound(track.begin(), track.end(), t_s,
                                      [](const TrackPoint& point, double t) { return point.t_s < t; });
  if (after == track.end()) return std::nullopt;
  if (after->t_s == t_s) return after->position_m;
  if (after == track.begin()) return std::nullopt;
  const auto before = after - 1;
  const double gap = after->t_s - before->t_s;
  if (gap > kLongestGapS) return std::nullopt;
  const double share = (t_s - before->t_s) / gap;
  return before->position_m + share * (after->position_m - before->position_m);
}

std::optional<ClockOffset> SearchByPositions(std::span<const TimedPosition> photos,
                                             std::span<const TrackPoint> track) {
  if (photos.size() < 4 || track.size() < 4) return std::nullopt;
  const auto errors_at = [&](double offset, std::size_t stride, std::vector<double>& errors) {
    errors.clear();
    for (std::size_t i = 0; i < photos.size(); i += stride) {
      const auto position = TrackAt(track, photos[i].t_s + offset);
      errors.push_back(position ? (*position - photos[i].position_m).norm()
                                : std::numeric_limits<double>::infinity());
    }
  };
  // Four fifths of the photos must lie on the track.
  const std::size_t spare = photos.size() / 5;
  const Range range{track.front().t_s - photos[spare].t_s,
                    track.back().t_s - photos[photos.size() - 1 - spare].t_s};
  auto found = Search(errors_at, photos.size(), range);
  if (!found) return std::nullopt;
  // Along-track errors over the sum of squared speeds; positions of one receiver err together for some
  // seconds.
  double speeds = 0.0, along = 0.0;
  std::size_t used = 0;
  for (const TimedPosition& photo : photos) {
    const auto before = TrackAt(track, photo.t_s + found->offset_s - 0.25);
    const auto at = TrackAt(track, photo.t_s + found->offset_s);
    const auto after = TrackAt(track, photo.t_s + found->offset_s + 0.25);
    if (!before || !at || !after) continue;
    const Eigen::Vector2d velocity = (*after - *before) / 0.5;
    const Eigen::Vector2d error = photo.position_m - *at;
    if (error.norm() > 10.0 * found->residual_m + 1.0) continue;
    speeds += velocity.squaredNorm();
    if (velocity.norm() > 0.5) along += std::pow(error.dot(velocity.normalized()), 2);
    ++used;
  }
  if (used < 4 || speeds < 1.0) return std::nullopt;
  const double correlated = 3.0;
  found->sigma_s = std::sqrt(correlated * (along / static_cast<double>(used) + 0.01) / speeds);
  return found;
}

}  // namespace skyquilt::poses
