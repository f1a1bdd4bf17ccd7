#include "core/alignment/features/scale_space.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <optional>
#include <span>

#include "core/base/vector_clones.h"

namespace skyquilt::alignment {
namespace {

constexpr float kLevels = 128.0F;      // of BlurredImage to a grey level
constexpr float kCameraBlurPx = 0.5F;  // what the image came with
constexpr int kMinSidePx = 24;
constexpr double kEdgeRatio = 12.0;
constexpr int kMaxBlurRadius = 16;

// Half of a symmetric kernel, in 65536ths.
struct Kernel {
  int radius = 0;
  std::array<std::uint16_t, kMaxBlurRadius + 1> weights{};  // by distance

  explicit Kernel(double sigma_px)
      : radius(std::min(kMaxBlurRadius, static_cast<int>(std::ceil(3.0 * sigma_px)))) {
    std::array<double, kMaxBlurRadius + 1> exact{};
    double sum = 0.0;
    for (int k = 0; k <= radius; ++k) {
      exact[k] = std::exp(-0.5 * k * k / (sigma_px * sigma_px));
      sum += (k == 0 ? 1.0 : 2.0) * exact[k];
    }
    for (int k = 0; k <= radius; ++k)
      weights[k] = static_cast<std::uint16_t>(std::lround(65536.0 * exact[k] / sum));
  }
};

inline std::uint16_t Weighed(std::uint16_t value, std::uint16_t weight) {
  return static_cast<std::uint16_t>((static_cast<std::uint32_t>(value) * weight) >> 16);
}

using Rows = std::array<const std::uint16_t*, kMaxBlurRadius + 1>;  // by distance

// Adds what lies k rows (or columns) away on both sides, for each k from 1 to the kernel's radius; values are
// below 2^15. Three distances at a time: the sums are loaded and stored less often.
SKYQUILT_VECTOR_CLONES void AddPairs(const Kernel& kernel, const Rows& before, const Rows& behind, int count,
                                     std::uint16_t* __restrict sum) {
  int k = 1;
  for (; k + 2 <= kernel.radius; k += 3) {
    const int first = k;
    const std::uint16_t* const a0 = before[first];
    const std::uint16_t* const b0 = behind[first];
    const std::uint16_t* const a1 = before[first + 1];
    const std::uint16_t* const b1 = behind[first + 1];
    const std::uint16_t* const a2 = before[first + 2];
    const std::uint16_t* const b2 = behind[first + 2];
    const std::uint16_t w0 = kernel.weights[first], w1 = kernel.weights[first + 1],
                        w2 = kernel.weights[first + 2];
    for (int x = 0; x < count; ++x) {
      const std::uint16_t of_0 = Weighed(static_cast<std::uint16_t>(a0[x] + b0[x]), w0);
      const std::uint16_t of_1 = Weighed(static_cast<std::uint16_t>(a1[x] + b1[x]), w1);
      const std::uint16_t of_2 = Weighed(static_cast<std::uint16_t>(a2[x] + b2[x]), w2);
      sum[x] = static_cast<std::uint16_t>(sum[x] + of_0 + of_1 + of_2);
    }
  }
  for (; k <= kernel.radius; ++k) {
    const std::uint16_t* const a = before[k];
    const std::uint16_t* const b = behind[k];
    const std::uint16_t weight = kernel.weights[k];
    for (int x = 0; x < count; ++x)
      sum[x] = static_cast<std::uint16_t>(sum[x] + Weighed(static_cast<std::uint16_t>(a[x] + b[x]), weight));
  }
}

SKYQUILT_VECTOR_CLONES void WeighMiddle(const std::uint16_t* here, std::uint16_t weight, int count,
                                        std::uint16_t* __restrict sum) {
  for (int x = 0; x < count; ++x) sum[x] = Weighed(here[x], weight);
}

// Through a Gaussian of up to five pixels (a wider one is cut off at sixteen): down each column, then along
// each row.
BlurredImage Blur(const BlurredImage& image, double sigma_px) {
  const Kernel kernel(sigma_px);
  const int width = image.width_px, height = image.height_px, radius = kernel.radius;
  BlurredImage blurred{width, height, {}};
  blurred.values.resize(image.values.size());
  std::vector<std::uint16_t> down(width + 2 * radius);
  std::uint16_t* const middle = down.data() + radius;
  Rows above{}, below{}, west{}, east{};
  for (int k = 1; k <= radius; ++k) west[k] = middle - k, east[k] = middle + k;
  for (int y = 0; y < height; ++y) {
    for (int k = 1; k <= radius; ++k) {
      above[k] = image.Row(std::max(0, y - k));
      below[k] = image.Row(std::min(height - 1, y + k));
    }
    WeighMiddle(image.Row(y), kernel.weights[0], width, middle);
    AddPairs(kernel, above, below, width, middle);
    std::fill_n(down.data(), radius, middle[0]);
    std::fill_n(middle + width, radius, middle[width - 1]);
    std::uint16_t* out = blurred.Row(y);
    WeighMiddle(middle, kernel.weights[0], width, out);
    AddPairs(kernel, west, east, width, out);
  }
  return blurred;
}

BlurredImage EverySecond(const BlurredImage& image) {
  BlurredImage half{image.width_px / 2, image.height_px / 2, {}};
  half.values.resize(static_cast<std::size_t>(half.width_px) * half.height_px);
  for (int y = 0; y < half.height_px; ++y) {
    const std::uint16_t* in = image.Row(2 * y);
    std::uint16_t* out = half.Row(y);
    for (int x = 0; x < half.width_px; ++x) out[x] = in[2 * x];
  }
  return half;
}

SKYQUILT_VECTOR_CLONES void Subtract(const std::uint16_t* coarser, const std::uint16_t* finer,
                                     std::size_t count, std::int16_t* __restrict difference) {
  for (std::size_t x = 0; x < count; ++x) difference[x] = static_cast<std::int16_t>(coarser[x] - finer[x]);
}

// Of three numbers taken by value: std::min would have their addresses, which keeps a loop from being vector
// instructions.
inline std::int16_t Least(std::int16_t a, std::int16_t b, std::int16_t c) {
  const std::int16_t lower = a < b ? a : b;
  return lower < c ? lower : c;
}
inline std::int16_t Most(std::int16_t a, std::int16_t b, std::int16_t c) {
  const std::int16_t higher = a > b ? a : b;
  return higher > c ? higher : c;
}

// The least and the most of each number and its neighbours, above and below and then on both sides; the first
// and the last number have none.
SKYQUILT_VECTOR_CLONES void FindExtremes(const std::int16_t* above, const std::int16_t* here,
                                         const std::int16_t* below, std::size_t count,
                                         std::int16_t* __restrict down_least,
                                         std::int16_t* __restrict down_most, std::int16_t* __restrict least,
                                         std::int16_t* __restrict most) {
  for (std::size_t x = 0; x < count; ++x) {
    down_least[x] = Least(above[x], here[x], below[x]);
    down_most[x] = Most(above[x], here[x], below[x]);
  }
  for (std::size_t x = 1; x + 1 < count; ++x) {
    least[x] = Least(down_least[x - 1], down_least[x], down_least[x + 1]);
    most[x] = Most(down_most[x - 1], down_most[x], down_most[x + 1]);
  }
}

// A row of one layer of differences with what lies around each of its numbers.
struct ExtremeRow {
  std::vector<std::int16_t> least, most;
};

// Not 0 where a number is beyond the threshold and none of those around it, in its own layer and the two next
// to it, is beyond it.
SKYQUILT_VECTOR_CLONES void MarkPeaks(const std::int16_t* values, std::span<const ExtremeRow, 3> around,
                                      std::size_t count, std::int16_t threshold,
                                      std::int16_t* __restrict is_peak) {
  const std::int16_t* const least_0 = around[0].least.data();
  const std::int16_t* const least_1 = around[1].least.data();
  const std::int16_t* const least_2 = around[2].least.data();
  const std::int16_t* const most_0 = around[0].most.data();
  const std::int16_t* const most_1 = around[1].most.data();
  const std::int16_t* const most_2 = around[2].most.data();
  const auto lowest_told = static_cast<std::int16_t>(-threshold);
  for (std::size_t x = 1; x + 1 < count; ++x) {
    const std::int16_t lowest = Least(least_0[x], least_1[x], least_2[x]);
    const std::int16_t highest = Most(most_0[x], most_1[x], most_2[x]);
    const std::int16_t value = values[x];
    const std::int16_t is_top = value > threshold ? std::int16_t{1} : std::int16_t{0};
    const std::int16_t is_bottom = value < lowest_told ? std::int16_t{1} : std::int16_t{0};
    const std::int16_t is_highest = value == highest ? std::int16_t{1} : std::int16_t{0};
    const std::int16_t is_lowest = value == lowest ? std::int16_t{1} : std::int16_t{0};
    is_peak[x] = static_cast<std::int16_t>((is_top & is_highest) | (is_bottom & is_lowest));
  }
}

// The pixels of an octave's differences that stand out from all around them, row by row: all of a row at
// once, which leaves few to look at one by one.
class RowPeaks {
 public:
  explicit RowPeaks(const Octave& octave)
      : octave_(octave),
        width_(octave.layers[0].width_px),
        down_least_(width_),
        down_most_(width_),
        is_peak_((width_ + 3) / 4 * 4, 0) {
    for (std::size_t layer = 0; layer < kDifferences; ++layer) {
      for (auto& row : differences_[layer]) row.resize(width_);
      extremes_[layer].least.resize(width_), extremes_[layer].most.resize(width_);
      for (int y = 0; y < 2; ++y) SubtractRow(layer, y);
    }
  }
  // Rows are gone to in turn, from the second to the last but one.
  void MoveTo(int y) {
    y_ = y;
    for (std::size_t layer = 0; layer < kDifferences; ++layer) {
      SubtractRow(layer, y + 1);
      FindExtremes(RowOf(layer, y - 1).data(), RowOf(layer, y).data(), RowOf(layer, y + 1).data(), width_,
                   down_least_.data(), down_most_.data(), extremes_[layer].least.data(),
                   extremes_[layer].most.data());
    }
  }
  // Of this row, in a layer that has others on both sides.
  template <typename Visit>
  void ForEach(std::size_t layer, std::int16_t threshold, const Visit& visit) {
    MarkPeaks(RowOf(layer, y_).data(), std::span<const ExtremeRow, 3>(extremes_.data() + layer - 1, 3),
              width_, threshold, is_peak_.data());
    for (std::size_t x = 0; x < is_peak_.size(); x += 4) {
      std::uint64_t four = 0;
      std::memcpy(&four, is_peak_.data() + x, 8);
      if (four == 0) continue;
      for (std::size_t k = x; k < x + 4; ++k) {
        if (is_peak_[k] != 0) visit(static_cast<int>(k));
      }
    }
  }

 private:
  static constexpr std::size_t kDifferences = kLayersAnOctave + 2;

  std::vector<std::int16_t>& RowOf(std::size_t layer, int y) { return differences_[layer][y % 3]; }
  void SubtractRow(std::size_t layer, int y) {
    Subtract(octave_.layers[layer + 1].Row(y), octave_.layers[layer].Row(y), width_, RowOf(layer, y).data());
  }

  const Octave& octave_;
  const std::size_t width_;
  int y_ = 0;
  std::array<std::array<std::vector<std::int16_t>, 3>, kDifferences> differences_;  // of three rows
  std::array<ExtremeRow, kDifferences> extremes_;
  std::vector<std::int16_t> down_least_, down_most_, is_peak_;
};

struct Place {
  int layer, x, y;
};

// Where between the pixels and layers the spot is (a paraboloid through its neighbours).
std::optional<ScalePoint> Refine(const Octave& octave, Place at, float min_contrast) {
  constexpr int kMaxSteps = 5;
  const BlurredImage& size = octave.layers[0];
  for (int step = 0; step < kMaxSteps; ++step) {
    const auto d = [&](int dx, int dy, int ds) -> double {
      const int layer = at.layer + ds, x = at.x + dx, y = at.y + dy;
      return octave.layers[layer + 1].Row(y)[x] - octave.layers[layer].Row(y)[x];
    };
    const double value = d(0, 0, 0);
    const double gx = 0.5 * (d(1, 0, 0) - d(-1, 0, 0)), gy = 0.5 * (d(0, 1, 0) - d(0, -1, 0)),
                 gs = 0.5 * (d(0, 0, 1) - d(0, 0, -1));
    const double xx = d(1, 0, 0) + d(-1, 0, 0) - 2.0 * value, yy = d(0, 1, 0) + d(0, -1, 0) - 2.0 * value,
                 ss = d(0, 0, 1) + d(0, 0, -1) - 2.0 * value;
    const double xy = 0.25 * (d(1, 1, 0) - d(-1, 1, 0) - d(1, -1, 0) + d(-1, -1, 0)),
                 xs = 0.25 * (d(1, 0, 1) - d(-1, 0, 1) - d(1, 0, -1) + d(-1, 0, -1)),
                 ys = 0.25 * (d(0, 1, 1) - d(0, -1, 1) - d(0, 1, -1) + d(0, -1, -1));
    // Cramer's rule for Hessian * offset = -gradient.
    const double c00 = yy * ss - ys * ys, c01 = xs * ys - xy * ss, c02 = xy * ys - xs * yy;
    const double det = xx * c00 + xy * c01 + xs * c02;
    if (std::abs(det) < 1e-9) return std::nullopt;
    const double c11 = xx * ss - xs * xs, c12 = xy * xs - xx * ys, c22 = xx * yy - xy * xy;
    const double ox = -(c00 * gx + c01 * gy + c02 * gs) / det, oy = -(c01 * gx + c11 * gy + c12 * gs) / det,
                 os = -(c02 * gx + c12 * gy + c22 * gs) / det;
    if (std::abs(ox) < 0.5 && std::abs(oy) < 0.5 && std::abs(os) < 0.5) {
      const double contrast = std::abs(value + 0.5 * (gx * ox + gy * oy + gs * os)) / kLevels;
      if (contrast < min_contrast) return std::nullopt;
      const double trace = xx + yy, flat = xx * yy - xy * xy;
      if (flat <= 0.0 || trace * trace * kEdgeRatio >= (kEdgeRatio + 1.0) * (kEdgeRatio + 1.0) * flat)
        return std::nullopt;
      return ScalePoint{0,
                        at.layer,
                        static_cast<float>(at.x + ox),
                        static_cast<float>(at.y + oy),
                        static_cast<float>(kFirstBlurPx * std::exp2((at.layer + os) / kLayersAnOctave)),
                        static_cast<float>(contrast)};
    }
    if (std::abs(ox) > 1e6 || std::abs(oy) > 1e6 || std::abs(os) > 1e6) return std::nullopt;
    at.x += static_cast<int>(std::lround(ox));
    at.y += static_cast<int>(std::lround(oy));
    at.layer += static_cast<int>(std::lround(os));
    if (at.layer < 1 || at.layer > kLayersAnOctave || at.x < 1 || at.y < 1 || at.x + 1 >= size.width_px ||
        at.y + 1 >= size.height_px) {
      return std::nullopt;
    }
  }
  return std::nullopt;
}

}  // namespace

std::vector<Octave> BuildScaleSpace(int width_px, int height_px, const std::uint8_t* grey) {
  BlurredImage image{width_px, height_px, {}};
  image.values.resize(static_cast<std::size_t>(width_px) * height_px);
  for (std::size_t i = 0; i < image.values.size(); ++i)
    image.values[i] = static_cast<std::uint16_t>(grey[i] * static_cast<int>(kLevels));
  image = Blur(image, std::sqrt(kFirstBlurPx * kFirstBlurPx - kCameraBlurPx * kCameraBlurPx));
  std::vector<Octave> octaves;
  for (int step_px = 1; octaves.empty() || std::min(image.width_px, image.height_px) >= kMinSidePx;
       step_px *= 2) {
    Octave octave;
    octave.step_px = step_px;
    octave.layers.push_back(std::move(image));
    for (int layer = 1; layer < kLayersAnOctave + 3; ++layer) {
      const double before = kFirstBlurPx * std::exp2((layer - 1.0) / kLayersAnOctave);
      const double growth = std::exp2(1.0 / kLayersAnOctave);
      octave.layers.push_back(Blur(octave.layers.back(), before * std::sqrt(growth * growth - 1.0)));
    }
    image = EverySecond(octave.layers[kLayersAnOctave]);
    octaves.push_back(std::move(octave));
  }
  return octaves;
}

std::vector<ScalePoint> FindScalePoints(const std::vector<Octave>& octaves, float min_contrast) {
  std::vector<ScalePoint> points;
  // A pixel may be a little weaker than the spot between it and its neighbours.
  const auto threshold = static_cast<std::int16_t>(0.5F * min_contrast * kLevels);
  for (std::size_t o = 0; o < octaves.size(); ++o) {
    const Octave& octave = octaves[o];
    RowPeaks peaks(octave);
    std::array<std::vector<ScalePoint>, kLayersAnOctave> of_layer;
    for (int y = 1; y + 1 < octave.layers[0].height_px; ++y) {
      peaks.MoveTo(y);
      for (std::size_t k = 0; k < kLayersAnOctave; ++k) {
        const int layer = static_cast<int>(k) + 1;
        peaks.ForEach(k + 1, threshold, [&](int x) {
          std::optional<ScalePoint> point = Refine(octave, {layer, x, y}, min_contrast);
          if (!point) return;
          point->octave = static_cast<int>(o);
          of_layer[k].push_back(*point);
        });
      }
    }
    for (const auto& found : of_layer) points.insert(points.end(), found.begin(), found.end());
  }
  return points;
}

}  // namespace skyquilt::alignment
