// ResampleBlock: a square of a target grid from the pixels of a map. Its places in the source come as those
// of the corners of smaller squares, between which they run straight. Pixels without alpha count for nothing;
// where the nearest one is such, nothing is shown. Pure; any thread. HalveBlocks: the block above four.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "core/image/rgba_image.h"
#include "storage/exports/warped/resampling_kernel.h"
#include "storage/exports/warped/source_window.h"

namespace skyquilt::storage {

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
