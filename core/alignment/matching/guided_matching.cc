#include "core/alignment/matching/guided_matching.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/vector_clones.h"
#include "core/geo/bounds.h"

namespace skyquilt::alignment {
namespace {

constexpr int kFarthest = std::numeric_limits<int>::max();
constexpr double kMaxGrownLog2 = 0.6;  // of one keypoint against the other, on the ground

SKYQUILT_VECTOR_CLONES int SquaredDistance(const Descriptor& a, const Descriptor& b) {
  int sum = 0;
  for (std::size_t k = 0; k < 128; ++k) {
    const auto apart = static_cast<std::int16_t>(a[k] - b[k]);
    sum += apart * apart;
  }
  return sum;
}

// Keypoints by square cells, so that a circle is looked up by the few cells it touches: number after number,
// for a loop over them to take several at once.
struct ByCell {
  std::vector<double> east, north;
  std::vector<float> angle_rad, log2_scale;
  std::vector<int> index;  // of the keypoint

  explicit ByCell(std::size_t count)
      : east(count), north(count), angle_rad(count), log2_scale(count), index(count) {}
};

struct Wanted {
  std::complex<double> place;
  double max_distance2, angle_rad, log2_scale, max_turn_rad;
};

// Marks which of the keypoints from `first` to before `last` are wanted.
SKYQUILT_VECTOR_CLONES void MarkWanted(const ByCell& cells, std::size_t first, std::size_t last,
                                       const Wanted& wanted, std::uint8_t* __restrict is_wanted) {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  const double* east = cells.east.data();
  const double* north = cells.north.data();
  const float* angle_rad = cells.angle_rad.data();
  const float* log2_scale = cells.log2_scale.data();
  const double at_east = wanted.place.real(), at_north = wanted.place.imag();
  for (std::size_t k = first; k < last; ++k) {
    const double de = east[k] - at_east, dn = north[k] - at_north;
    const double grown = std::abs(static_cast<double>(log2_scale[k]) - wanted.log2_scale);
    // Angles are a few turns at most: no division.
    double turn = std::abs(static_cast<double>(angle_rad[k]) - wanted.angle_rad);
    turn = turn > kTurn ? turn - kTurn : turn;
    turn = turn > kTurn ? turn - kTurn : turn;
    turn = std::min(turn, kTurn - turn);
    is_wanted[k] = static_cast<std::uint8_t>((de * de + dn * dn <= wanted.max_distance2) &
                                             (grown <= kMaxGrownLog2) & (turn <= wanted.max_turn_rad));
  }
}

class CellIndex {
 public:
  CellIndex(const std::vector<GroundKeypoint>& projected, int count, double cell_m)
      : members_(std::count_if(projected.begin(), projected.begin() + count,
                               [](const GroundKeypoint& one) { return one.is_on_ground; })),
        is_wanted_(members_.index.size()) {
    for (int i = 0; i < count; ++i) {
      if (projected[i].is_on_ground)
        bounds_.Include(Eigen::Vector2d(projected[i].place.real(), projected[i].place.imag()));
    }
    if (bounds_.IsEmpty()) return;
    cell_m_ = std::max({cell_m, bounds_.Width() / 64.0, bounds_.Height() / 64.0, 1e-6});
    columns_ = static_cast<int>(bounds_.Width() / cell_m_) + 1;
    rows_ = static_cast<int>(bounds_.Height() / cell_m_) + 1;
    starts_.assign(static_cast<std::size_t>(columns_) * rows_ + 1, 0);
    for (int i = 0; i < count; ++i) {
      if (projected[i].is_on_ground) ++starts_[CellOf(projected[i].place) + 1];
    }
    for (std::size_t c = 1; c < starts_.size(); ++c) starts_[c] += starts_[c - 1];
    std::vector<std::size_t> next(starts_.begin(), starts_.end() - 1);
    for (int i = 0; i < count; ++i) {
      if (!projected[i].is_on_ground) continue;
      const std::size_t k = next[CellOf(projected[i].place)]++;
      members_.east[k] = projected[i].place.real(), members_.north[k] = projected[i].place.imag();
      members_.angle_rad[k] = projected[i].angle_rad, members_.log2_scale[k] = projected[i].log2_scale;
      members_.index[k] = i;
    }
  }

  template <typename Visit>
  void ForEach(const Wanted& wanted, const Visit& visit) {
    if (members_.index.empty()) return;
    const double radius_m = std::sqrt(wanted.max_distance2);
    const auto clamp = [](double cells, int size) {
      return static_cast<int>(std::clamp(std::floor(cells), -1.0, static_cast<double>(size)));
    };
    const double east_m = wanted.place.real() - bounds_.min.x(),
                 north_m = wanted.place.imag() - bounds_.min.y();
    const int left = std::max(0, clamp((east_m - radius_m) / cell_m_, columns_));
    const int right = std::min(columns_ - 1, clamp((east_m + radius_m) / cell_m_, columns_));
    const int low = std::max(0, clamp((north_m - radius_m) / cell_m_, rows_));
    const int high = std::min(rows_ - 1, clamp((north_m + radius_m) / cell_m_, rows_));
    if (left > right) return;
    for (int row = low; row <= high; ++row) {
      const std::size_t of_row = static_cast<std::size_t>(row) * columns_;
      const std::size_t first = starts_[of_row + left], last = starts_[of_row + right + 1];
      MarkWanted(members_, first, last, wanted, is_wanted_.data());
      for (std::size_t k = first; k < last; ++k) {
        if (is_wanted_[k] != 0) visit(members_.index[k]);
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
  std::vector<std::size_t> starts_;
  ByCell members_;
  std::vector<std::uint8_t> is_wanted_;
};

struct BestTwo {
  int best = kFarthest, second = kFarthest, index = -1;

  void Offer(int distance, int candidate, const PhotoFeatures& features) {
    if (distance >= best && distance >= second) return;
    const bool same = index >= 0 && AreOnePatch(features, index, candidate);
    if (distance < best) {
      if (!same) second = best;
      best = distance;
      index = candidate;
    } else if (!same) {
      second = distance;
    }
  }
};

}  // namespace

std::vector<KeypointMatch> MatchOnGround(const std::vector<const PhotoFeatures*>& features,
                                         const GroundKeypoints& projected, int first, int second,
                                         const MatchWindow& window) {
  const PhotoFeatures& features_first = *features[first];
  const PhotoFeatures& features_second = *features[second];
  const std::vector<GroundKeypoint>& projected_first = projected[first];
  const std::vector<GroundKeypoint>& projected_second = projected[second];
  const int count_first = std::min<int>(window.max_features, static_cast<int>(projected_first.size()));
  const int count_second = std::min<int>(window.max_features, static_cast<int>(projected_second.size()));
  const bool anywhere = !std::isfinite(window.radius_m);
  const double radius_m = anywhere ? 1e9 : window.radius_m;
  CellIndex index(projected_second, count_second, anywhere ? 1e9 : 0.5 * window.radius_m);
  std::vector<BestTwo> of_first(count_first), of_second(count_second);
  for (int i = 0; i < count_first; ++i) {
    if (!projected_first[i].is_on_ground) continue;
    const GroundKeypoint& one = projected_first[i];
    const Wanted wanted{one.place, radius_m * radius_m, one.angle_rad, one.log2_scale, window.max_turn_rad};
    index.ForEach(wanted, [&](int j) {
      const int distance = SquaredDistance(features_first.descriptors[i], features_second.descriptors[j]);
      of_first[i].Offer(distance, j, features_second);
      of_second[j].Offer(distance, i, features_first);
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
    matches.emplace_back(i, forth.index);
  }
  return matches;
}

}  // namespace skyquilt::alignment
