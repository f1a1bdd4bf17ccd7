// ResamplingKernel: what each pixel of a row of the source counts for a place between them, by a table of
// phases. Pixels of the target that are larger than the source's by `ratio` take in so many more of them. A
// value; any thread. Source: R. G. Keys, "Cubic Convolution Interpolation for Digital Image Processing", IEEE
// ASSP 29(6), 1981, with a = -1/2.
#pragma once

#include <vector>

namespace skyquilt::storage {

class ResamplingKernel {
 public:
  // Precondition: ratio > 0.
  static ResamplingKernel Cubic(double ratio);
  // The mean over the target's pixel.
  static ResamplingKernel Average(double ratio);

  // Source pixels on each axis; the first one, counted from that whose centre comes before the place.
  int size() const { return size_; }
  int first() const { return first_; }
  // size() of them, their sum 1. `fraction`: of the way from that centre to the next, 0 to 1.
  const float* WeightsAt(float fraction) const {
    return weights_.data() + static_cast<std::size_t>(fraction * kPhases) * static_cast<std::size_t>(size_);
  }

 private:
  static constexpr int kPhases = 256;
  template <typename Weight>
  ResamplingKernel(double reach_px, const Weight& weight);

  int size_ = 0;
  int first_ = 0;
  std::vector<float> weights_;  // of each phase, and once more of the last
};

}  // namespace skyquilt::storage
