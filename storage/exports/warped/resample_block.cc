#include "storage/exports/warped/resample_block.h"

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

namespace {

// Red, green, blue and 1, or nothing at all: what is left of the 1 says how much was there.
using Pixel4 = float __attribute__((vector_size(16)));

constexpr std::uint8_t kShown = 128;

// The part of the window below one square, as floats.
class Patch {
 public:
  // Inclusive, in the window's pixels; it may reach beyond.
  void Fill(const SourceWindow& window, int left, int top, int right, int bottom) {
    left_ = left;
    top_ = top;
    width_ = right - left + 1;
    pixels_.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(bottom - top + 1), Pixel4{});
    std::size_t shown = 0;
    const int from_x = std::max(left, 0), to_x = std::min(right + 1, window.pixels.width_px);
    for (int y = std::max(top, 0); y < std::min(bottom + 1, window.pixels.height_px); ++y) {
      if (from_x >= to_x) break;
      Pixel4* out = At(from_x, y);
      const std::uint8_t* in = window.pixels.Pixel(from_x, y);
      for (int x = from_x; x < to_x; ++x, ++out, in += 4) {
        if (in[3] < kShown) continue;
        *out = Pixel4{static_cast<float>(in[0]), static_cast<float>(in[1]), static_cast<float>(in[2]), 1.0F};
        ++shown;
      }
    }
    is_empty_ = shown == 0;
    is_full_ = shown == pixels_.size();
  }
  bool is_empty() const { return is_empty_; }
  bool is_full() const { return is_full_; }
  int width() const { return width_; }
  Pixel4* At(int x, int y) {
    return pixels_.data() + static_cast<std::size_t>(y - top_) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(x - left_);
  }

 private:
  int left_ = 0, top_ = 0, width_ = 0;
  bool is_empty_ = true, is_full_ = false;
  std::vector<Pixel4> pixels_;
};

std::uint8_t Rounded255(float value) {
  return static_cast<std::uint8_t>(std::clamp(value + 0.5F, 0.0F, 255.0F));
}

Pixel4 Weighed(const Pixel4* pixels, int stride, const float* across, const float* down, int size) {
  Pixel4 sum{};
  for (int j = 0; j < size; ++j, pixels += stride) {
    Pixel4 row{};
    for (int i = 0; i < size; ++i) row += across[i] * pixels[i];
    sum += down[j] * row;
  }
  return sum;
}

struct Square {
  Eigen::Vector2d north_west, north_east, south_west, south_east;

  // Near enough to be looked at at all.
  bool IsWithin(const image::RgbaImage& window) const {
    constexpr double kMaxSidePx = 2048.0;
    const Eigen::Vector2d low = Lowest(), high = Highest();
    const bool is_finite =
        north_west.allFinite() && north_east.allFinite() && south_west.allFinite() && south_east.allFinite();
    return is_finite && (high - low).maxCoeff() < kMaxSidePx && high.minCoeff() > -kMaxSidePx &&
           low.x() < window.width_px + kMaxSidePx && low.y() < window.height_px + kMaxSidePx;
  }
  Eigen::Vector2d Lowest() const {
    return north_west.cwiseMin(north_east).cwiseMin(south_west).cwiseMin(south_east);
  }
  Eigen::Vector2d Highest() const {
    return north_west.cwiseMax(north_east).cwiseMax(south_west).cwiseMax(south_east);
  }
};

void ResampleSquare(Patch& patch, const Square& square, const ResamplingKernel& kernel, std::uint8_t* out,
                    std::size_t out_stride) {
  constexpr float kMinShown = 0.25F;  // of the weights: less says little of a colour
  const int size = kernel.size(), first = kernel.first();
  for (int y = 0; y < kWarpedStepPx; ++y, out += out_stride) {
    const double down = (y + 0.5) / kWarpedStepPx;
    const Eigen::Vector2d left = square.north_west + down * (square.south_west - square.north_west);
    const Eigen::Vector2d right = square.north_east + down * (square.south_east - square.north_east);
    const Eigen::Vector2d step = (right - left) / kWarpedStepPx;
    Eigen::Vector2d place = left + 0.5 * step;
    std::uint8_t* pixel = out;
    for (int x = 0; x < kWarpedStepPx; ++x, place += step, pixel += 4) {
      const Pixel4* nearest = nullptr;
      if (!patch.is_full()) {
        nearest = patch.At(static_cast<int>(std::floor(place.x())), static_cast<int>(std::floor(place.y())));
        if ((*nearest)[3] == 0.0F) continue;
      }
      const double column = std::floor(place.x() - 0.5), row = std::floor(place.y() - 0.5);
      const float* across = kernel.WeightsAt(static_cast<float>(place.x() - 0.5 - column));
      const float* along = kernel.WeightsAt(static_cast<float>(place.y() - 0.5 - row));
      Pixel4 sum = Weighed(patch.At(static_cast<int>(column) + first, static_cast<int>(row) + first),
                           patch.width(), across, along, size);
      if (nearest != nullptr && sum[3] < kMinShown) sum = *nearest;
      const float scale = 1.0F / sum[3];
      for (int c = 0; c < 3; ++c) pixel[c] = Rounded255(sum[c] * scale);
      pixel[3] = 255;
    }
  }
}

void HalveInto(const image::RgbaImage& image, image::RgbaImage& half, int left, int top) {
  for (int y = 0; 2 * y < image.height_px; ++y) {
    std::uint8_t* out = half.Pixel(left, top + y);
    for (int x = 0; 2 * x < image.width_px; ++x, out += 4) {
      int sums[3] = {0, 0, 0}, shown = 0;
      for (int v = 2 * y; v < std::min(2 * y + 2, image.height_px); ++v) {
        for (int u = 2 * x; u < std::min(2 * x + 2, image.width_px); ++u) {
          const std::uint8_t* pixel = image.Pixel(u, v);
          if (pixel[3] < kShown) continue;
          ++shown;
          for (int c = 0; c < 3; ++c) sums[c] += pixel[c];
        }
      }
      if (shown < 2) continue;
      for (int c = 0; c < 3; ++c) out[c] = static_cast<std::uint8_t>((sums[c] + shown / 2) / shown);
      out[3] = 255;
    }
  }
}

}  // namespace

bool ResampleBlock(const SourceWindow& window, const BlockCorners& corners, const ResamplingKernel& kernel,
                   image::RgbaImage& block) {
  Patch patch;
  bool shows = false;
  for (int j = 0; j < kStepsOfBlock; ++j) {
    for (int i = 0; i < kStepsOfBlock; ++i) {
      const auto at = [&](int row, int column) -> const Eigen::Vector2d& {
        return corners[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)];
      };
      const Square square{at(j, i), at(j, i + 1), at(j + 1, i), at(j + 1, i + 1)};
      const Eigen::Vector2d low = square.Lowest(), high = square.Highest();
      if (!square.IsWithin(window.pixels)) continue;
      const int before = 1 - kernel.first(), behind = kernel.first() + kernel.size();
      patch.Fill(window, static_cast<int>(std::floor(low.x())) - before,
                 static_cast<int>(std::floor(low.y())) - before,
                 static_cast<int>(std::floor(high.x())) + behind,
                 static_cast<int>(std::floor(high.y())) + behind);
      if (patch.is_empty()) continue;
      shows = true;
      ResampleSquare(patch, square, kernel, block.Pixel(i * kWarpedStepPx, j * kWarpedStepPx),
                     4 * static_cast<std::size_t>(block.width_px));
    }
  }
  return shows;
}

image::RgbaImage Halved(const image::RgbaImage& image) {
  auto half = image::RgbaImage::Transparent((image.width_px + 1) / 2, (image.height_px + 1) / 2);
  HalveInto(image, half, 0, 0);
  return half;
}

image::RgbaImage HalveBlocks(const std::array<const image::RgbaImage*, 4>& blocks) {
  image::RgbaImage half = image::RgbaImage::Transparent(kWarpedBlockPx, kWarpedBlockPx);
  constexpr int kHalf = kWarpedBlockPx / 2;
  for (std::size_t quarter = 0; quarter < blocks.size(); ++quarter) {
    if (blocks[quarter] == nullptr) continue;
    HalveInto(*blocks[quarter], half, quarter % 2 == 1 ? kHalf : 0, quarter / 2 == 1 ? kHalf : 0);
  }
  return half;
}

}  // namespace skyquilt::storage
