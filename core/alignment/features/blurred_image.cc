#include "core/alignment/features/blurred_image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/base/vector_clones.h"

namespace skyquilt::alignment {
namespace {

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

}  // namespace

// Down each column, then along each row.
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

}  // namespace skyquilt::alignment
