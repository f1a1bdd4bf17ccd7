#include "core/image/yuv_planes.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "core/base/vector_clones.h"

namespace skyquilt::image {
namespace {

constexpr int kYuvBits = 16;  // of the weights below

// Of a row.
SKYQUILT_VECTOR_CLONES void FillLuma(const std::uint8_t* rgba, std::size_t count, std::uint8_t* __restrict y,
                                     std::uint8_t* __restrict alpha) {
  constexpr std::uint32_t kBlack = (16U << kYuvBits) + (1U << (kYuvBits - 1));
  for (std::size_t x = 0; x < count; ++x) {
    const std::uint32_t red = rgba[4 * x], green = rgba[4 * x + 1], blue = rgba[4 * x + 2];
    y[x] = static_cast<std::uint8_t>((16839 * red + 33059 * green + 6420 * blue + kBlack) >> kYuvBits);
    alpha[x] = rgba[4 * x + 3];
  }
}

// Sums over two by two pixels.
struct FourSums {
  std::vector<std::uint16_t> red, green, blue, alpha;

  explicit FourSums(std::size_t count) : red(count), green(count), blue(count), alpha(count) {}
};

SKYQUILT_VECTOR_CLONES void AddFours(const std::uint8_t* upper, const std::uint8_t* lower, std::size_t count,
                                     std::uint16_t* __restrict red, std::uint16_t* __restrict green,
                                     std::uint16_t* __restrict blue, std::uint16_t* __restrict alpha) {
  for (std::size_t x = 0; x < count; ++x) {
    const std::uint8_t* const above = upper + 8 * x;
    const std::uint8_t* const below = lower + 8 * x;
    red[x] = static_cast<std::uint16_t>(above[0] + above[4] + below[0] + below[4]);
    green[x] = static_cast<std::uint16_t>(above[1] + above[5] + below[1] + below[5]);
    blue[x] = static_cast<std::uint16_t>(above[2] + above[6] + below[2] + below[6]);
    alpha[x] = static_cast<std::uint16_t>(above[3] + above[7] + below[3] + below[7]);
  }
}

// Where some of the four have less alpha than others, each counts by its own.
void WeighByAlpha(const std::uint8_t* upper, const std::uint8_t* lower, std::size_t count, FourSums& sums) {
  constexpr unsigned kAllOpaque = 4 * 255;
  for (std::size_t x = 0; x < count; ++x) {
    const unsigned alpha = sums.alpha[x];
    if (alpha == kAllOpaque || alpha == 0) continue;
    std::array<unsigned, 3> weighed{};
    for (const std::uint8_t* pixel : {upper + 8 * x, upper + 8 * x + 4, lower + 8 * x, lower + 8 * x + 4}) {
      for (std::size_t c = 0; c < 3; ++c) weighed[c] += pixel[c] * unsigned{pixel[3]};
    }
    const auto of_four = [&](unsigned sum) {
      return static_cast<std::uint16_t>((4 * sum + alpha / 2) / alpha);
    };
    sums.red[x] = of_four(weighed[0]), sums.green[x] = of_four(weighed[1]),
    sums.blue[x] = of_four(weighed[2]);
  }
}

SKYQUILT_VECTOR_CLONES void FillChroma(const std::uint16_t* red, const std::uint16_t* green,
                                       const std::uint16_t* blue, std::size_t count,
                                       std::uint8_t* __restrict u, std::uint8_t* __restrict v) {
  constexpr int kBits = kYuvBits + 2;  // sums of four
  constexpr int kGrey = (128 << kBits) + (1 << (kBits - 1));
  for (std::size_t x = 0; x < count; ++x) {
    const int r = red[x], g = green[x], b = blue[x];
    u[x] = static_cast<std::uint8_t>((-9719 * r - 19081 * g + 28800 * b + kGrey) >> kBits);
    v[x] = static_cast<std::uint8_t>((28800 * r - 24116 * g - 4684 * b + kGrey) >> kBits);
  }
}

}  // namespace

void FillYuvPlanes(const RgbaImage& straight, const YuvPlanes& planes) {
  const auto width = static_cast<std::size_t>(straight.width_px);
  const std::size_t halves = (width + 1) / 2;
  FourSums sums(halves);
  // The last column and row of an odd number stand for the missing ones too.
  std::array<std::vector<std::uint8_t>, 2> even;
  const auto row_of = [&](int y, std::size_t which) -> const std::uint8_t* {
    const std::uint8_t* const row = straight.Pixel(0, std::min(y, straight.height_px - 1));
    if (width % 2 == 0) return row;
    even[which].assign(row, row + 4 * width);
    even[which].insert(even[which].end(), row + 4 * (width - 1), row + 4 * width);
    return even[which].data();
  };
  for (int y = 0; y < straight.height_px; ++y) {
    FillLuma(straight.Pixel(0, y), width, planes.y + static_cast<std::ptrdiff_t>(y) * planes.y_row_bytes,
             planes.alpha + static_cast<std::ptrdiff_t>(y) * planes.alpha_row_bytes);
  }
  for (int y = 0; y < straight.height_px; y += 2) {
    const std::uint8_t* const upper = row_of(y, 0);
    const std::uint8_t* const lower = row_of(y + 1, 1);
    AddFours(upper, lower, halves, sums.red.data(), sums.green.data(), sums.blue.data(), sums.alpha.data());
    WeighByAlpha(upper, lower, halves, sums);
    const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(y / 2) * planes.uv_row_bytes;
    FillChroma(sums.red.data(), sums.green.data(), sums.blue.data(), halves, planes.u + at, planes.v + at);
  }
}

}  // namespace skyquilt::image
