#include "core/render/cubic_sampler.h"

#include <algorithm>
#include <cmath>

#if defined(__SSE2__)
#include <emmintrin.h>
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
  constexpr double a = -0.75;
  const double t = std::abs(distance);
  if (t < 1.0) return ((a + 2.0) * t - (a + 3.0)) * t * t + 1.0;
  if (t < 2.0) return ((a * t - 5.0 * a) * t + 8.0 * a) * t - 4.0 * a;
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

#if defined(__SSE2__)

inline void Inside(const std::uint8_t* corner, std::ptrdiff_t stride, const PhaseWeights& along,
                   const PhaseWeights& down, SampledPixel& pixel) {
  const auto load = [&](int row) {
    return _mm_loadu_si128(reinterpret_cast<const __m128i*>(corner + row * stride));
  };
  const auto pair = [&](int first) {
    return _mm_set1_epi32((static_cast<int>(down.down[static_cast<std::size_t>(first) + 1]) << 16) |
                          static_cast<std::uint16_t>(down.down[static_cast<std::size_t>(first)]));
  };
  const __m128i zero = _mm_setzero_si128();
  const __m128i upper = pair(0), lower = pair(2);
  const __m128i a = load(0), b = load(1), c = load(2), d = load(3);
  const __m128i ab = _mm_unpacklo_epi8(a, b), ab_end = _mm_unpackhi_epi8(a, b);
  const __m128i cd = _mm_unpacklo_epi8(c, d), cd_end = _mm_unpackhi_epi8(c, d);
  // Four columns of numbers at a time, each the weighted sum of four rows.
  const auto sum = [&](const __m128i& first, const __m128i& second) {
    return _mm_cvtepi32_ps(_mm_add_epi32(_mm_madd_epi16(first, upper), _mm_madd_epi16(second, lower)));
  };
  const __m128 r0g0b0r1 = sum(_mm_unpacklo_epi8(ab, zero), _mm_unpacklo_epi8(cd, zero));
  const __m128 g1b1r2g2 = sum(_mm_unpackhi_epi8(ab, zero), _mm_unpackhi_epi8(cd, zero));
  const __m128 b2r3g3b3 = sum(_mm_unpacklo_epi8(ab_end, zero), _mm_unpacklo_epi8(cd_end, zero));
  const __m128 x = _mm_mul_ps(r0g0b0r1, _mm_load_ps(along.along.data()));
  const __m128 y = _mm_mul_ps(g1b1r2g2, _mm_load_ps(along.along.data() + 4));
  const __m128 z = _mm_mul_ps(b2r3g3b3, _mm_load_ps(along.along.data() + 8));
  const __m128 x3x3y0y1 = _mm_shuffle_ps(x, y, _MM_SHUFFLE(1, 0, 3, 3));
  const __m128 second = _mm_shuffle_ps(x3x3y0y1, x3x3y0y1, _MM_SHUFFLE(3, 3, 2, 1));
  const __m128 third = _mm_shuffle_ps(y, z, _MM_SHUFFLE(0, 0, 3, 2));
  const __m128 fourth = _mm_shuffle_ps(z, z, _MM_SHUFFLE(3, 3, 2, 1));
  _mm_storeu_ps(pixel.data(), _mm_add_ps(_mm_add_ps(x, second), _mm_add_ps(third, fourth)));
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

#endif

}  // namespace

CubicSampler::CubicSampler(const pipeline::DecodedImage& image)
    : rgb_(image.rgb.data()),
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

void CubicSampler::Row(float x, float y, float step_x, float step_y, int count, SampledPixel* pixels) const {
  const auto& weights = Weights();
  constexpr int kWholePx = 5;  // what sixteen bytes reach beyond a window's first pixel
  for (int i = 0; i < count; ++i) {
    const float at_x = x + static_cast<float>(i) * step_x, at_y = y + static_cast<float>(i) * step_y;
    // Not a number compares false.
    const float safe_x = at_x > -kFarPx && at_x < kFarPx ? at_x : -kFarPx;
    const float safe_y = at_y > -kFarPx && at_y < kFarPx ? at_y : -kFarPx;
    // West and north of the photo, where these round up instead of down, all is its edge.
    const int fine_x = static_cast<int>(safe_x * kPhases + 0.5F),
              fine_y = static_cast<int>(safe_y * kPhases + 0.5F);
    const int column = fine_x >> kPhaseBits, row = fine_y >> kPhaseBits;
    const int phase_x = fine_x & (kPhases - 1), phase_y = fine_y & (kPhases - 1);
    if (column >= 1 && row >= 1 && column - 1 + kWholePx < width_px_ && row + 2 < height_px_) {
      Inside(rgb_ + (row - 1) * stride_ + 3 * (column - 1), stride_,
             weights[static_cast<std::size_t>(phase_x)], weights[static_cast<std::size_t>(phase_y)],
             pixels[i]);
    } else {
      AtEdge(column, row, phase_x, phase_y, pixels[i]);
    }
  }
}

}  // namespace skyquilt::render
