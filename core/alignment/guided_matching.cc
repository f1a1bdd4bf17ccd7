#include "core/alignment/guided_matching.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/geo/bounds.h"

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace skyquilt::alignment {
namespace {

constexpr int kFarthest = std::numeric_limits<int>::max();

int SquaredDistance(const Descriptor& a, const Descriptor& b) {
#if defined(__SSE2__)
  const __m128i zero = _mm_setzero_si128();
  __m128i sum = zero;
  for (int k = 0; k < 128; k += 16) {
    const __m128i x = _mm_loadu_si128(reinterpret_cast<const __m128i*>(a.data() + k));
    const __m128i y = _mm_loadu_si128(reinterpret_cast<const __m128i*>(b.data() + k));
    const __m128i apart = _mm_or_si128(_mm_subs_epu8(x, y), _mm_subs_epu8(y, x));
    const __m128i low = _mm_unpacklo_epi8(apart, zero);
    const __m128i high = _mm_unpackhi_epi8(apart, zero);
    sum = _mm_add_epi32(sum, _mm_add_epi32(_mm_madd_epi16(low, low), _mm_madd_epi16(high, high)));
  }
  sum = _mm_add_epi32(sum, _mm_shuffle_epi32(sum, _MM_SHUFFLE(1, 0, 3, 2)));
  sum = _mm_add_epi32(sum, _mm_shuffle_epi32(sum, _MM_SHUFFLE(2, 3, 0, 1)));
  return _mm_cvtsi128_si32(sum);
#else
  int sum = 0;
  for (int k = 0; k < 128; ++k) {
    const int apart = static_cast<int>(a[k]) - static_cast<int>(b[k]);
    sum += apart * apart;
  }
  return sum;
#endif
}

// Keypoints in square cells, so that a circle is looked up by the few cells it touches.
class CellIndex {
 public:
  CellIndex(const std::vector<GroundKeypoint>& laid, int count, double cell_m) {
    for (int i = 0; i < count; ++i) {
      if (laid[i].is_on_ground) bounds_.Include(Eigen::Vector2d(laid[i].place.real(), laid[i].place.imag()));
    }
    if (bounds_.IsEmpty()) return;
    cell_m_ = std::max({cell_m, bounds_.Width() / 64.0, bounds_.Height() / 64.0, 1e-6});
    columns_ = static_cast<int>(bounds_.Width() / cell_m_) + 1;
    rows_ = static_cast<int>(bounds_.Height() / cell_m_) + 1;
    starts_.assign(static_cast<std::size_t>(columns_) * rows_ + 1, 0);
    for (int i = 0; i < count; ++i) {
      if (laid[i].is_on_ground) ++starts_[CellOf(laid[i].place) + 1];
    }
    for (std::size_t c = 1; c < starts_.size(); ++c) starts_[c] += starts_[c - 1];
    members_.resize(starts_.back());
    std::vector<int> next(starts_.begin(), starts_.end() - 1);
    for (int i = 0; i < count; ++i) {
      if (laid[i].is_on_ground) members_[next[CellOf(laid[i].place)]++] = i;
    }
  }

  template <typename Visit>
  void Around(std::complex<double> place, double radius_m, const Visit& visit) const {
    if (members_.empty()) return;
    const auto clamp = [](double cells, int size) {
      return static_cast<int>(std::clamp(std::floor(cells), -1.0, static_cast<double>(size)));
    };
    const int left = std::max(0, clamp((place.real() - radius_m - bounds_.min.x()) / cell_m_, columns_));
    const int right =
        std::min(columns_ - 1, clamp((place.real() + radius_m - bounds_.min.x()) / cell_m_, columns_));
    const int low = std::max(0, clamp((place.imag() - radius_m - bounds_.min.y()) / cell_m_, rows_));
    const int high = std::min(rows_ - 1, clamp((place.imag() + radius_m - bounds_.min.y()) / cell_m_, rows_));
    for (int row = low; row <= high; ++row) {
      for (int column = left; column <= right; ++column) {
        const std::size_t cell = static_cast<std::size_t>(row) * columns_ + column;
        for (int k = starts_[cell]; k < starts_[cell + 1]; ++k) visit(members_[k]);
      }
    }
  }

 private:
  std::size_t CellOf(std::complex<double> place) const {
    const int column = std::min(columns_ - 1, static_cast<int>((place.real() - bounds_.min.x()) / cell_m_));
    const int row = std::min(rows_ - 1, static_cast<int>((place.imag() - bounds_.min.y()) / cell_m_));
    return static_cast<std::size_t>(row) * columns_ + column;
  }

  geo::Bounds2 bounds_;
  double cell_m_ = 1.0;
  int columns_ = 0, rows_ = 0;
  std::vector<int> starts_, members_;
};

struct BestTwo {
  int best = kFarthest, second = kFarthest, index = -1;

  // `same`: the newcomer is the present best seen again (another direction of one keypoint), not a rival.
  void Offer(int distance, int candidate, bool same) {
    if (distance < best) {
      if (!same) second = best;
      best = distance;
      index = candidate;
    } else if (!same && distance < second) {
      second = distance;
    }
  }
};

// 0 to pi. The innermost question of the search, and the angles are a few turns at most: no division.
double TurnBetween(double from_rad, double to_rad) {
  double turn = std::abs(to_rad - from_rad);
  while (turn > 2.0 * std::numbers::pi) turn -= 2.0 * std::numbers::pi;
  return std::min(turn, 2.0 * std::numbers::pi - turn);
}

}  // namespace

std::vector<KeypointMatch> MatchOnGround(const GroundView& first, const GroundView& second,
                                         const GroundSimilarity& second_from_first,
                                         const MatchWindow& window) {
  const std::vector<GroundKeypoint>& laid_first = *first.laid;
  const std::vector<GroundKeypoint>& laid_second = *second.laid;
  const int count_first = std::min<int>(window.max_features, static_cast<int>(laid_first.size()));
  const int count_second = std::min<int>(window.max_features, static_cast<int>(laid_second.size()));
  const bool anywhere = !std::isfinite(window.radius_m);
  const double radius_m = anywhere ? 1e9 : window.radius_m;
  const CellIndex index(laid_second, count_second, anywhere ? 1e9 : 0.5 * window.radius_m);
  const double turned = std::arg(second_from_first.turn_and_scale);
  const double grown = std::log2(std::abs(second_from_first.turn_and_scale));
  const auto is_same = [](const PhotoFeatures& features, int a, int b) {
    if (a < 0) return false;
    const Keypoint& x = features.keypoints[a];
    const Keypoint& y = features.keypoints[b];
    const float dx = x.x_px - y.x_px, dy = x.y_px - y.y_px, near = 0.5F * std::min(x.scale_px, y.scale_px);
    return dx * dx + dy * dy < near * near;
  };
  std::vector<BestTwo> of_first(count_first), of_second(count_second);
  for (int i = 0; i < count_first; ++i) {
    if (!laid_first[i].is_on_ground) continue;
    const std::complex<double> expected = second_from_first * laid_first[i].place;
    index.Around(expected, radius_m, [&](int j) {
      const GroundKeypoint& other = laid_second[j];
      if (!anywhere && std::norm(other.place - expected) > radius_m * radius_m) return;
      if (std::abs(other.log2_scale - laid_first[i].log2_scale - grown) > window.max_log2_scale) return;
      if (TurnBetween(laid_first[i].angle_rad + turned, other.angle_rad) > window.max_turn_rad) return;
      const int distance = SquaredDistance(first.features->descriptors[i], second.features->descriptors[j]);
      of_first[i].Offer(distance, j, is_same(*second.features, of_first[i].index, j));
      of_second[j].Offer(distance, i, is_same(*first.features, of_second[j].index, i));
    });
  }
  const double max_ratio = window.max_distance_ratio * window.max_distance_ratio;
  std::vector<KeypointMatch> matches;
  for (int i = 0; i < count_first; ++i) {
    const BestTwo& forth = of_first[i];
    if (forth.index < 0) continue;
    const BestTwo& back = of_second[forth.index];
    if (back.index != i) continue;
    if (forth.best > max_ratio * forth.second || back.best > max_ratio * back.second) continue;
    matches.push_back({i, forth.index});
  }
  return matches;
}

}  // namespace skyquilt::alignment
