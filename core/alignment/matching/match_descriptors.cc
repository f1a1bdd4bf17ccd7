#include "core/alignment/matching/match_descriptors.h"

#include <algorithm>
#include <cstdint>
#include <limits>

#include "core/base/vector_clones.h"

namespace skyquilt::alignment {
namespace {

constexpr int kRowsAtOnce = 4;
constexpr double kMaxDistanceRatio = 0.85;

// Widened, so that products are summed in pairs by one instruction.
struct Wide {
  std::vector<std::int16_t> rows;
  std::vector<std::int32_t> square;
  int count = 0;
};

Wide Widen(const PhotoFeatures& features, int most) {
  Wide wide;
  wide.count = std::min(most, static_cast<int>(features.descriptors.size()));
  const int padded = (wide.count + kRowsAtOnce - 1) / kRowsAtOnce * kRowsAtOnce;
  wide.rows.assign(static_cast<std::size_t>(padded) * kDescriptorSize, 0);
  wide.square.assign(padded, 0);
  for (int i = 0; i < wide.count; ++i) {
    std::int16_t* row = wide.rows.data() + static_cast<std::size_t>(i) * kDescriptorSize;
    const Descriptor& descriptor = features.descriptors[i];
    int square = 0;
    for (int k = 0; k < kDescriptorSize; ++k) {
      row[k] = descriptor[k];
      square += row[k] * row[k];
    }
    wide.square[i] = square;
  }
  return wide;
}

// distances[r * columns + j] = |column j|^2 - 2 row r * column j, for four rows: what varies of the squared
// distance.
SKYQUILT_VECTOR_CLONES void CompareFour(const std::int16_t* __restrict rows,
                                        const std::int16_t* __restrict columns,
                                        const std::int32_t* __restrict square, int count,
                                        std::int32_t* __restrict distances) {
  const std::int16_t* a0 = rows;
  const std::int16_t* a1 = rows + kDescriptorSize;
  const std::int16_t* a2 = rows + 2 * kDescriptorSize;
  const std::int16_t* a3 = rows + 3 * kDescriptorSize;
  for (int j = 0; j < count; ++j) {
    const std::int16_t* b = columns + static_cast<std::size_t>(j) * kDescriptorSize;
    std::int32_t s0 = 0, s1 = 0, s2 = 0, s3 = 0;
    for (int k = 0; k < kDescriptorSize; ++k) {
      s0 += a0[k] * b[k];
      s1 += a1[k] * b[k];
      s2 += a2[k] * b[k];
      s3 += a3[k] * b[k];
    }
    distances[j] = square[j] - 2 * s0;
    distances[count + j] = square[j] - 2 * s1;
    distances[2 * count + j] = square[j] - 2 * s2;
    distances[3 * count + j] = square[j] - 2 * s3;
  }
}

SKYQUILT_VECTOR_CLONES std::int32_t Least(const std::int32_t* values, int count) {
  std::int32_t least = std::numeric_limits<std::int32_t>::max();
  for (int j = 0; j < count; ++j) least = std::min(least, values[j]);
  return least;
}

SKYQUILT_VECTOR_CLONES int CountBelow(const std::int32_t* values, int count, std::int32_t limit) {
  int below = 0;
  for (int j = 0; j < count; ++j) below += values[j] < limit ? 1 : 0;
  return below;
}

// The nearest of the row, where it stands out from all at other places; -1: none does.
int StandsOut(const std::int32_t* distances, int count, std::int32_t square, double max_ratio2,
              const PhotoFeatures& features) {
  const std::int32_t least = Least(distances, count);
  const auto limit =
      static_cast<std::int32_t>(std::min(2e9, static_cast<double>(least + square) / max_ratio2)) - square + 1;
  const int nearest = static_cast<int>(std::find(distances, distances + count, least) - distances);
  if (CountBelow(distances, count, limit) > 1) {
    for (int j = 0; j < count; ++j) {
      if (distances[j] < limit && j != nearest && !AreOnePatch(features, j, nearest)) return -1;
    }
  }
  return nearest;
}

}  // namespace

std::vector<KeypointMatch> MatchDescriptors(const PhotoFeatures& first, const PhotoFeatures& second,
                                            int max_features) {
  const Wide a = Widen(first, max_features), b = Widen(second, max_features);
  std::vector<KeypointMatch> matches;
  if (a.count == 0 || b.count == 0) return matches;
  constexpr double kMaxRatio2 = kMaxDistanceRatio * kMaxDistanceRatio;
  std::vector<KeypointMatch> forth;
  std::vector<std::int32_t> distances(static_cast<std::size_t>(kRowsAtOnce) * std::max(a.count, b.count));
  for (int i = 0; i < a.count; i += kRowsAtOnce) {
    CompareFour(a.rows.data() + static_cast<std::size_t>(i) * kDescriptorSize, b.rows.data(), b.square.data(),
                b.count, distances.data());
    for (int r = 0; r < kRowsAtOnce && i + r < a.count; ++r) {
      const int j = StandsOut(distances.data() + r * b.count, b.count, a.square[i + r], kMaxRatio2, second);
      if (j >= 0) forth.emplace_back(i + r, j);
    }
  }
  // Back again, only for those: the second's view of all of the first.
  std::vector<std::int16_t> chosen(kRowsAtOnce * kDescriptorSize, 0);
  for (std::size_t m = 0; m < forth.size(); m += kRowsAtOnce) {
    const std::size_t rows = std::min<std::size_t>(kRowsAtOnce, forth.size() - m);
    for (std::size_t r = 0; r < rows; ++r) {
      const std::int16_t* row = b.rows.data() + forth[m + r].second * kDescriptorSize;
      std::copy(row, row + kDescriptorSize,
                chosen.begin() + static_cast<std::ptrdiff_t>(r * kDescriptorSize));
    }
    CompareFour(chosen.data(), a.rows.data(), a.square.data(), a.count, distances.data());
    for (std::size_t r = 0; r < rows; ++r) {
      const int i = StandsOut(distances.data() + r * a.count, a.count, b.square[forth[m + r].second],
                              kMaxRatio2, first);
      if (i == forth[m + r].first) matches.push_back(forth[m + r]);
    }
  }
  return matches;
}

}  // namespace skyquilt::alignment
