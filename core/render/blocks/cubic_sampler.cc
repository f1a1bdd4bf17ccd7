#include "core/render/blocks/cubic_sampler.h"

#include <algorithm>
#include <cmath>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace skyquilt::render {
namespace {

constexpr int kPhaseBits = 6;
constexpr int kPhases = 1 << kPhaseBits;
constexpr int kDownBits = 14;  // of the weights between rows, which are whole numbers
constexpr float kFarPx = 1e5F;

struct alignas(16) PhaseWeights {
  // Of the pixels -1, 0, 1, 2 along, divided by the sum of the weights down; each as often as RGB RGB RGB RGB
  // asks.
  std::array<float, 12> along{};
  std::array<std::int16_t, 4> down{};
};

double Keys(double distance) {
  constexpr double kBend = -0.75;
  const double t = std::abs(distance);
  if (t < 1.0) return ((kBend + 2.0) * t - (kBend + 3.0)) * t * t + 1.0;
  if (t < 2.0) return ((kBend * t - 5.0 * kBend) * t + 8.0 * kBend) * t - 4.0 * kBend;
  return 0.0;
}

const std::array<PhaseWeights, kPhases>& Weights() {
  static const std::array<PhaseWeights, kPhases> table = [] {
    std::array<PhaseWeights, kPhases> made;
    for (int phase = 0; phase < kPhases; ++phase) {
      PhaseWeights& weights = made[static_cast<std::size_t>(phase)];
      int rest = 1 << kDownBits;
      for (int tap = 0; tap < 4; ++tap) {
        const double weight = Keys(static_cast<double>(phase) / kPhases - (tap - 1));
        for (int c = 0; c < 3; ++c)
          weights.along[static_cast<std::size_t>(3 * tap + c)] =
              static_cast<float>(weight / (1 << kDownBits));
        weights.down[static_cast<std::size_t>(tap)] =
            static_cast<std::int16_t>(std::lround(weight * (1 << kDownBits)));
        rest -= weights.down[static_cast<std::size_t>(tap)];
      }
      // Rounding must not make the photo brighter or darker.
      weights.down[phase < kPhases / 2 ? 1 : 2] += static_cast<std::int16_t>(rest);
    }
    return made;
  }();
  return table;
}

// Where so many neighbouring pixels lie in the photo: whole pixels and phases between them.
constexpr int kRun = 16;
struct Run {
  std::array<std::int32_t, kRun> column, row, phase_x, phase_y;
};

struct Pixels {
  const std::uint8_t* rgb;
  std::ptrdiff_t stride;

  // Of the window around a pixel.
  const std::uint8_t* Corner(int column, int row) const {
    return rgb + (row - 1) * stride + 3 * (static_cast<std::ptrdiff_t>(column) - 1);
  }
};

// The pixels that there are of a photo.
struct Extent {
  int left_px, top_px, width_px, height_px;
};

// kRun of them. True: the windows of all lie among the pixels that there are.
inline bool FindRun(const float* x, const float* y, const Extent& extent, Run& run) {
  constexpr int kWholePx = 5;  // what sixteen bytes reach beyond a window's first pixel
  std::int32_t outside = 0;
  for (int i = 0; i < kRun; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const float at_x = x[i], at_y = y[i];
    // Not a number compares false.
    const float safe_x = at_x > -kFarPx && at_x < kFarPx ? at_x : -kFarPx;
    const float safe_y = at_y > -kFarPx && at_y < kFarPx ? at_y : -kFarPx;
    // West and north of the photo, where these round up instead of down, all is its edge.
    const int fine_x = static_cast<int>(safe_x * kPhases + 0.5F),
              fine_y = static_cast<int>(safe_y * kPhases + 0.5F);
    run.column[k] = (fine_x >> kPhaseBits) - extent.left_px;
    run.row[k] = (fine_y >> kPhaseBits) - extent.top_px;
    run.phase_x[k] = fine_x & (kPhases - 1), run.phase_y[k] = fine_y & (kPhases - 1);
    // Negative where one of them is.
    outside |= (run.column[k] - 1) | (run.row[k] - 1) | (extent.width_px - kWholePx - run.column[k]) |
               (extent.height_px - 3 - run.row[k]);
  }
  return outside >= 0;
}

#if defined(__x86_64__)

inline void Inside(const std::uint8_t* corner, std::ptrdiff_t stride, const PhaseWeights& along,
                   const PhaseWeights& down, SampledPixel& pixel) {
  const auto load = [&](int row) {
    return _mm_loadu_si128(reinterpret_cast<const __m128i*>(corner + row * stride));
  };
  const __m128i zero = _mm_setzero_si128();
  const __m128i weights = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(down.down.data()));
  const __m128i upper = _mm_shuffle_epi32(weights, 0x00), lower = _mm_shuffle_epi32(weights, 0x55);
  const __m128i a = load(0), b = load(1), c = load(2), d = load(3);
  const __m128i ab = _mm_unpacklo_epi8(a, b), ab_end = _mm_unpackhi_epi8(a, b);
  const __m128i cd = _mm_unpacklo_epi8(c, d), cd_end = _mm_unpackhi_epi8(c, d);
  // Four columns of numbers at a time, each the weighted sum of four rows.
  const auto sum = [&](const __m128i& first, const __m128i& second, int column) {
    return _mm_mul_ps(
        _mm_cvtepi32_ps(_mm_add_epi32(_mm_madd_epi16(first, upper), _mm_madd_epi16(second, lower))),
        _mm_load_ps(along.along.data() + column));
  };
  const __m128 x = sum(_mm_unpacklo_epi8(ab, zero), _mm_unpacklo_epi8(cd, zero), 0);  // r0 g0 b0 r1
  const __m128 y = sum(_mm_unpackhi_epi8(ab, zero), _mm_unpackhi_epi8(cd, zero), 4);  // g1 b1 r2 g2
  const __m128 z = sum(_mm_unpacklo_epi8(ab_end, zero), _mm_unpacklo_epi8(cd_end, zero), 8);
  const __m128 x3x3y0y1 = _mm_shuffle_ps(x, y, _MM_SHUFFLE(1, 0, 3, 3));
  const __m128 second = _mm_shuffle_ps(x3x3y0y1, x3x3y0y1, _MM_SHUFFLE(3, 3, 2, 1));
  const __m128 third = _mm_shuffle_ps(y, z, _MM_SHUFFLE(0, 0, 3, 2));
  const __m128 fourth = _mm_shuffle_ps(z, z, _MM_SHUFFLE(3, 3, 2, 1));
  _mm_storeu_ps(pixel.data(), _mm_add_ps(_mm_add_ps(x, second), _mm_add_ps(third, fourth)));
}

#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx2"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx2")
#endif

// Inside for two neighbouring pixels by the same sums, one in the lower half of each register, one in the
// upper.
inline void TwoInside(const std::uint8_t* corner_0, const std::uint8_t* corner_1, std::ptrdiff_t stride,
                      const PhaseWeights& along_0, const PhaseWeights& along_1, const PhaseWeights& down_0,
                      const PhaseWeights& down_1, SampledPixel* pixels) {
  const auto load = [&](std::ptrdiff_t offset) {
    return _mm256_inserti128_si256(
        _mm256_castsi128_si256(_mm_loadu_si128(reinterpret_cast<const __m128i*>(corner_0 + offset))),
        _mm_loadu_si128(reinterpret_cast<const __m128i*>(corner_1 + offset)), 1);
  };
  const __m256i zero = _mm256_setzero_si256();
  const __m256i weights = _mm256_inserti128_si256(
      _mm256_castsi128_si256(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(down_0.down.data()))),
      _mm_loadl_epi64(reinterpret_cast<const __m128i*>(down_1.down.data())), 1);
  const __m256i upper = _mm256_shuffle_epi32(weights, 0x00), lower = _mm256_shuffle_epi32(weights, 0x55);
  const __m256i a = load(0), b = load(stride), c = load(2 * stride), d = load(3 * stride);
  const __m256i ab = _mm256_unpacklo_epi8(a, b), ab_end = _mm256_unpackhi_epi8(a, b);
  const __m256i cd = _mm256_unpacklo_epi8(c, d), cd_end = _mm256_unpackhi_epi8(c, d);
  const auto sum = [&](const __m256i& first, const __m256i& second, int column) {
    const __m256 along =
        _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_load_ps(along_0.along.data() + column)),
                             _mm_load_ps(along_1.along.data() + column), 1);
    return _mm256_mul_ps(_mm256_cvtepi32_ps(_mm256_add_epi32(_mm256_madd_epi16(first, upper),
                                                             _mm256_madd_epi16(second, lower))),
                         along);
  };
  const __m256 x = sum(_mm256_unpacklo_epi8(ab, zero), _mm256_unpacklo_epi8(cd, zero), 0);
  const __m256 y = sum(_mm256_unpackhi_epi8(ab, zero), _mm256_unpackhi_epi8(cd, zero), 4);
  const __m256 z = sum(_mm256_unpacklo_epi8(ab_end, zero), _mm256_unpacklo_epi8(cd_end, zero), 8);
  const __m256 x3x3y0y1 = _mm256_shuffle_ps(x, y, _MM_SHUFFLE(1, 0, 3, 3));
  const __m256 second = _mm256_shuffle_ps(x3x3y0y1, x3x3y0y1, _MM_SHUFFLE(3, 3, 2, 1));
  const __m256 third = _mm256_shuffle_ps(y, z, _MM_SHUFFLE(0, 0, 3, 2));
  const __m256 fourth = _mm256_shuffle_ps(z, z, _MM_SHUFFLE(3, 3, 2, 1));
  _mm256_storeu_ps(pixels[0].data(), _mm256_add_ps(_mm256_add_ps(x, second), _mm256_add_ps(third, fourth)));
}

int EvenInside(const Pixels& photo, const Run& run, int count, SampledPixel* pixels) {
  const auto& weights = Weights();
  const auto at = [&](int phase) -> const PhaseWeights& { return weights[static_cast<std::size_t>(phase)]; };
  std::size_t i = 0;
  for (; i + 1 < static_cast<std::size_t>(count); i += 2) {
    TwoInside(photo.Corner(run.column[i], run.row[i]), photo.Corner(run.column[i + 1], run.row[i + 1]),
              photo.stride, at(run.phase_x[i]), at(run.phase_x[i + 1]), at(run.phase_y[i]),
              at(run.phase_y[i + 1]), pixels + i);
  }
  return static_cast<int>(i);
}

#if defined(__clang__)
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif

// How many of the first pixels were made.
int AsManyInside(const Pixels& photo, const Run& run, int count, SampledPixel* pixels) {
  static const bool has_avx2 = __builtin_cpu_supports("avx2") != 0;
  return has_avx2 ? EvenInside(photo, run, count, pixels) : 0;
}

#else

inline void Inside(const std::uint8_t* corner, std::ptrdiff_t stride, const PhaseWeights& along,
                   const PhaseWeights& down, SampledPixel& pixel) {
  pixel = {};
  for (int i = 0; i < 12; ++i) {
    int sum = 0;
    for (int row = 0; row < 4; ++row)
      sum += corner[row * stride + i] * down.down[static_cast<std::size_t>(row)];
    pixel[static_cast<std::size_t>(i % 3)] +=
        static_cast<float>(sum) * along.along[static_cast<std::size_t>(i)];
  }
}

int AsManyInside(const Pixels&, const Run&, int, SampledPixel*) { return 0; }

#endif

}  // namespace

CubicSampler::CubicSampler(const image::DecodedImage& image, int left_px, int top_px)
    : rgb_(image.rgb.data()),
      left_px_(left_px),
      top_px_(top_px),
      width_px_(image.width_px),
      height_px_(image.height_px),
      stride_(static_cast<std::ptrdiff_t>(image.width_px) * 3) {}

void CubicSampler::AtEdge(int column, int row, int phase_x, int phase_y, SampledPixel& pixel) const {
  // The sixteen pixels, each as near as the photo has it.
  std::array<std::uint8_t, 4 * 16> around{};
  for (int dy = 0; dy < 4; ++dy) {
    const int y = std::clamp(row + dy - 1, 0, height_px_ - 1);
    for (int dx = 0; dx < 4; ++dx) {
      const int x = std::clamp(column + dx - 1, 0, width_px_ - 1);
      std::copy_n(rgb_ + y * stride_ + 3 * x, 3, around.data() + 16 * dy + 3 * dx);
    }
  }
  const auto& weights = Weights();
  Inside(around.data(), 16, weights[static_cast<std::size_t>(phase_x)],
         weights[static_cast<std::size_t>(phase_y)], pixel);
}

void CubicSampler::At(const float* x, const float* y, int count, SampledPixel* pixels) const {
  const auto& weights = Weights();
  const Pixels photo{rgb_, stride_};
  const Extent extent{left_px_, top_px_, width_px_, height_px_};
  Run run;
  for (int first = 0; first < count; first += kRun, x += kRun, y += kRun, pixels += kRun) {
    const int here = std::min(kRun, count - first);
    std::array<float, kRun> end_x, end_y;
    const bool is_whole = here == kRun;
    if (!is_whole) {  // the last place again, as often as a run is longer
      std::fill(std::copy_n(x, here, end_x.begin()), end_x.end(), x[here - 1]);
      std::fill(std::copy_n(y, here, end_y.begin()), end_y.end(), y[here - 1]);
    }
    const bool is_inside = FindRun(is_whole ? x : end_x.data(), is_whole ? y : end_y.data(), extent, run);
    for (int i = is_inside ? AsManyInside(photo, run, here, pixels) : 0; i < here; ++i) {
      const auto k = static_cast<std::size_t>(i);
      if (is_inside) {
        Inside(photo.Corner(run.column[k], run.row[k]), stride_,
               weights[static_cast<std::size_t>(run.phase_x[k])],
               weights[static_cast<std::size_t>(run.phase_y[k])], pixels[i]);
      } else {
        AtEdge(run.column[k], run.row[k], run.phase_x[k], run.phase_y[k], pixels[i]);
      }
    }
  }
}

}  // namespace skyquilt::render
