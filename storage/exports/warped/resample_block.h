// ResampleBlock: a square of a target grid from the pixels of a map. Its places in the source come as those
// of the corners of smaller squares, between which they run straight. Pixels without alpha count for nothing;
// where the nearest one is such, nothing is shown. HalveBlocks: the block above four. Pure; any thread.
// Source: R. G. Keys, "Cubic Convolution Interpolation for Digital Image Processing", IEEE ASSP 29(6), 1981,
// with a = -1/2.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "core/image/rgba_image.h"
#include "storage/exports/warped/source_window.h"

namespace skyquilt::storage {

// What each pixel of a row of the source counts for a place between them, by a table of phases. Pixels of the
// target that are larger than the source's by `ratio` take in so many more of them. A value; any thread.
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

inline constexpr int kWarpedBlockPx = 512;
inline constexpr int kWarpedStepPx = 64;  // between the corners
inline constexpr int kStepsOfBlock = kWarpedBlockPx / kWarpedStepPx;

// Of column i and row j, 0 to kStepsOfBlock, in the source's pixels from the window's corner. Where one of a
// square's is no number, or the square reaches too far, nothing is shown.
using BlockCorners = std::array<std::array<Eigen::Vector2d, kStepsOfBlock + 1>, kStepsOfBlock + 1>;  // [j][i]

// Straight alpha, 0 or 255. Nothing shown: false, and `block` is as it was.
bool ResampleBlock(const SourceWindow& window, const BlockCorners& corners, const ResamplingKernel& kernel,
                   image::RgbaImage& block);

// Each pixel is the mean of those of two by two that are shown, where at least two are.
image::RgbaImage Halved(const image::RgbaImage& image);

// North-west, north-east, south-west, south-east; null where nothing is shown.
image::RgbaImage HalveBlocks(const std::array<const image::RgbaImage*, 4>& blocks);

}  // namespace skyquilt::storage
