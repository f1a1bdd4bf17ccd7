#include "storage/exports/warped/resampling_kernel.h"

#include <algorithm>
#include <cmath>

namespace skyquilt::storage {
namespace {

double CubicAt(double distance) {
  const double t = std::abs(distance);
  if (t >= 2.0) return 0.0;
  return t < 1.0 ? (1.5 * t - 2.5) * t * t + 1.0 : ((-0.5 * t + 2.5) * t - 4.0) * t + 2.0;
}

}  // namespace

// `weight` of a pixel whose centre lies so far from the place.
template <typename Weight>
ResamplingKernel::ResamplingKernel(double reach_px, const Weight& weight)
    : size_(2 * static_cast<int>(std::ceil(reach_px))), first_(1 - size_ / 2) {
  weights_.reserve(static_cast<std::size_t>(kPhases + 1) * static_cast<std::size_t>(size_));
  for (int phase = 0; phase <= kPhases; ++phase) {
    const double fraction = (std::min(phase, kPhases - 1) + 0.5) / kPhases;
    std::vector<double> row;
    double sum = 0.0;
    for (int i = 0; i < size_; ++i) {
      row.push_back(weight(first_ + i - fraction));
      sum += row.back();
    }
    for (const double value : row) weights_.push_back(static_cast<float>(value / sum));
  }
}

ResamplingKernel ResamplingKernel::Cubic(double ratio) {
  constexpr double kSameSize = 0.95;  // within this nothing is smoothed
  const double scale = ratio > 1.0 / kSameSize ? 1.0 / ratio : 1.0;
  return {2.0 / scale, [&](double distance) { return CubicAt(distance * scale); }};
}

ResamplingKernel ResamplingKernel::Average(double ratio) {
  const double half = std::max(ratio, 1.0) / 2.0;
  return {half + 0.5, [&](double distance) {
            return std::max(0.0, std::min(distance + 0.5, half) - std::max(distance - 0.5, -half));
          }};
}

}  // namespace skyquilt::storage
