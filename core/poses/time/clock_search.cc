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

// Cauchy cost per photo; those off the track cost as much as a gross error. The scale is that of a receiver's
// noise.
double CostOf(const std::vector<double>& errors, double scale) {
  double sum = 0.0;
  for (const double error : errors) {
    const double z = std::isfinite(error) ? error / scale : 100.0;
    sum += std::log1p(std::min(z * z, 1e4));
  }
  return sum / static_cast<double>(errors.size());
}

struct Range {
  double from_s;
  double to_s;
};

std::optional<ClockOffset> Search(const ErrorsAt& errors_at, std::size_t count, Range range, double scale) {
  if (!(range.to_s >= range.from_s)) return std::nullopt;
  const double step = std::max(kCoarseStepS, (range.to_s - range.from_s) / static_cast<double>(kMaxSteps));
  const std::size_t stride = std::max<std::size_t>(1, count / kMaxPhotosCoarse);
  const auto steps = static_cast<std::size_t>((range.to_s - range.from_s) / step) + 1;
  std::vector<double> errors;
  std::vector<double> costs(steps);
  for (std::size_t k = 0; k < steps; ++k) {
    errors_at(range.from_s + step * static_cast<double>(k), stride, errors);
    costs[k] = CostOf(errors, scale);
  }
  const auto best = static_cast<std::size_t>(std::min_element(costs.begin(), costs.end()) - costs.begin());
  double rival = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < steps; ++k) {
    if (std::abs(static_cast<double>(k) - static_cast<double>(best)) * step > 10.0)
      rival = std::min(rival, costs[k]);
  }
  ClockOffset found;
  // Narrowing grids around the minimum.
  double middle = range.from_s + step * static_cast<double>(best);
  double reach = 2.0 * step;
  double lowest = costs[best];
  while (reach > 2e-3) {
    double at = middle;
    lowest = std::numeric_limits<double>::infinity();
    for (int k = -10; k <= 10; ++k) {
      const double offset = middle + reach * k / 10.0;
      errors_at(offset, 1, errors);
      const double cost = CostOf(errors, scale);
      if (cost < lowest) {
        lowest = cost;
        at = offset;
      }
    }
    middle = at;
    reach *= 0.2;
  }
  found.offset_s = middle;
  found.rival_cost_ratio = std::isfinite(rival) && rival > 0.0 ? lowest / rival : 0.0;
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
  auto found = Search(errors_at, photos.size(), range, 1.0);
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

std::optional<ClockOffset> SearchByDistances(std::span<const TimedDistance> distances,
                                             std::span<const TrackPoint> track, bool scale_is_known) {
  if (distances.size() < 8 || track.size() < 4) return std::nullopt;
  const auto lengths_at = [&](double offset, std::size_t stride, std::vector<double>& lengths) {
    lengths.clear();
    for (std::size_t i = 0; i < distances.size(); i += stride) {
      const auto from = TrackAt(track, distances[i].from_s + offset);
      const auto to = TrackAt(track, distances[i].to_s + offset);
      lengths.push_back(from && to ? (*to - *from).norm() : std::numeric_limits<double>::infinity());
    }
  };
  const auto scale_of = [&](const std::vector<double>& lengths, std::size_t stride) {
    if (scale_is_known) return 1.0;
    std::vector<double> ratios;
    for (std::size_t i = 0, k = 0; i < distances.size(); i += stride, ++k) {
      if (std::isfinite(lengths[k]) && distances[i].distance > 0.0 && lengths[k] > 0.5) {
        ratios.push_back(lengths[k] / distances[i].distance);
      }
    }
    return ratios.size() < 4 ? std::numeric_limits<double>::infinity() : Median(std::move(ratios));
  };
  std::vector<double> lengths;
  const auto errors_at = [&](double offset, std::size_t stride, std::vector<double>& errors) {
    lengths_at(offset, stride, lengths);
    const double scale = scale_of(lengths, stride);
    errors.clear();
    for (std::size_t i = 0, k = 0; i < distances.size(); i += stride, ++k) {
      errors.push_back(std::isfinite(scale) ? lengths[k] - scale * distances[i].distance
                                            : std::numeric_limits<double>::infinity());
    }
  };
  const std::size_t spare = distances.size() / 5;
  const Range range{track.front().t_s - distances[spare].from_s,
                    track.back().t_s - distances[distances.size() - 1 - spare].to_s};
  auto found = Search(errors_at, distances.size(), range, 0.3);
  if (!found) return std::nullopt;
  // How fast the lengths change with the offset says how well they fix it.
  std::vector<double> early, late, errors;
  errors_at(found->offset_s - 0.25, 1, early);
  errors_at(found->offset_s + 0.25, 1, late);
  errors_at(found->offset_s, 1, errors);
  double slope_square = 0.0, error_square = 0.0;
  std::size_t used = 0;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    if (!std::isfinite(early[i]) || !std::isfinite(late[i]) || !std::isfinite(errors[i])) continue;
    if (std::abs(errors[i]) > 10.0 * found->residual_m + 0.5) continue;
    slope_square += std::pow((late[i] - early[i]) / 0.5, 2);
    error_square += errors[i] * errors[i];
    ++used;
  }
  if (used < 8 || slope_square < 0.5) return std::nullopt;
  found->sigma_s = std::sqrt((error_square / static_cast<double>(used) + 1e-4) / slope_square);
  return found;
}

}  // namespace skyquilt::poses
