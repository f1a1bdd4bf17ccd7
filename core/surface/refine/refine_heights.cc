#include "core/surface/refine/refine_heights.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "core/base/vector_clones.h"

namespace skyquilt::surface {
namespace {

constexpr int kDirections = 8;
constexpr std::array<std::array<int, 2>, kDirections> kAround = {
    {{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}}};
constexpr std::size_t kMinMet = 5;

struct Met {
  float height_m = 0.0f;
  float weight = 0.0f;
};

SKYQUILT_VECTOR_CLONES void MedianRow(const float* below, const float* here, const float* above, int count,
                                      float* __restrict medians) {
  const auto order = [](float& a, float& b) {
    const float least = std::min(a, b);
    b = std::max(a, b);
    a = least;
  };
  for (int i = 0; i < count; ++i) {
    // The shortest network that sorts as much as is needed of nine (Devillard 1998).
    float p0 = below[i], p1 = below[i + 1], p2 = below[i + 2], p3 = here[i], p4 = here[i + 1],
          p5 = here[i + 2], p6 = above[i], p7 = above[i + 1], p8 = above[i + 2];
    order(p1, p2), order(p4, p5), order(p7, p8), order(p0, p1), order(p3, p4), order(p6, p7);
    order(p1, p2), order(p4, p5), order(p7, p8), order(p0, p3), order(p5, p8), order(p4, p7);
    order(p3, p6), order(p1, p4), order(p2, p5), order(p4, p7), order(p4, p2), order(p6, p4);
    order(p4, p2);
    medians[i] = p4;
  }
}

// By cell and direction: how many cells away the next known one lies; 0: none within reach. A cell has what
// the one before it that way has, and one more.
using Gone = std::array<std::uint8_t, kDirections>;
std::vector<Gone> NextKnown(const LevelHeights& level, int reach) {
  std::vector<Gone> all_gone(level.is_known.size(), Gone{});
  Gone* const gone = all_gone.data();
  const std::uint8_t* const is_known = level.is_known.data();
  const auto follow = [&](int column, int row, std::size_t direction) {
    const int x = column + kAround[direction][0], y = row + kAround[direction][1];
    if (x < 0 || y < 0 || x >= level.columns || y >= level.rows) return;
    const std::size_t other = level.IndexOf(x, y);
    const int before = gone[other][direction];
    const bool is_within = is_known[other] != 0 || (before != 0 && before < reach);
    if (is_within)
      gone[level.IndexOf(column, row)][direction] =
          static_cast<std::uint8_t>(is_known[other] != 0 ? 1 : before + 1);
  };
  constexpr std::array<std::size_t, kDirections / 2> kBack = {4, 5, 6, 7}, kForth = {0, 1, 2, 3};
  for (int row = 0; row < level.rows; ++row) {
    for (int column = 0; column < level.columns; ++column) {
      for (const std::size_t direction : kBack) follow(column, row, direction);
    }
  }
  for (int row = level.rows - 1; row >= 0; --row) {
    for (int column = level.columns - 1; column >= 0; --column) {
      for (const std::size_t direction : kForth) follow(column, row, direction);
    }
  }
  return all_gone;
}

// By insertion: they are a few.
void SortByHeight(std::array<Met, kDirections>& met, std::size_t count) {
  for (std::size_t i = 1; i < count; ++i) {
    for (std::size_t at = i; at > 0 && met[at].height_m < met[at - 1].height_m; --at)
      std::swap(met[at], met[at - 1]);
  }
}

}  // namespace

void FillUnknown(LevelHeights& level, const std::vector<float>& expected_m, int reach, float most_step_m) {
  const std::vector<Gone> next = NextKnown(level, reach);
  for (int row = 0; row < level.rows; ++row) {
    for (int column = 0; column < level.columns; ++column) {
      const std::size_t cell = level.IndexOf(column, row);
      if (level.is_known[cell] != 0) continue;
      std::array<Met, kDirections> met;
      std::size_t count = 0;
      for (std::size_t direction = 0; direction < kDirections; ++direction) {
        const int gone = next[cell][direction];
        if (gone == 0) continue;
        const auto& [step_x, step_y] = kAround[direction];
        const std::size_t other = level.IndexOf(column + gone * step_x, row + gone * step_y);
        met[count++] = {level.heights_m[other], 1.0f / static_cast<float>(gone)};
      }
      // Only known cells are read, so that filled ones do not spread.
      level.heights_m[cell] = expected_m[cell];
      if (count < kMinMet) continue;
      SortByHeight(met, count);
      float sum = 0.0f, weights = 0.0f;
      for (std::size_t i = 0; i < count && met[i].height_m <= met[1].height_m + most_step_m; ++i) {
        if (met[i].height_m < met[1].height_m - most_step_m) continue;
        sum += met[i].weight * met[i].height_m;
        weights += met[i].weight;
      }
      level.heights_m[cell] = sum / weights;
    }
  }
}

std::vector<std::uint8_t> MeansAround(const std::vector<std::uint8_t>& values, int columns, int rows) {
  constexpr int kReach = 2;
  std::vector<int> sums(static_cast<std::size_t>(columns));  // of each column, over the rows about this one
  std::vector<std::uint8_t> means(values.size());
  const auto add = [&](int row, int sign) {
    if (row < 0 || row >= rows) return;
    const std::uint8_t* from = values.data() + static_cast<std::size_t>(row) * columns;
    for (int column = 0; column < columns; ++column)
      sums[static_cast<std::size_t>(column)] += sign * from[column];
  };
  for (int row = 0; row < kReach; ++row) add(row, 1);
  for (int row = 0; row < rows; ++row) {
    add(row + kReach, 1);
    add(row - kReach - 1, -1);
    const int up = std::min(rows - 1, row + kReach) - std::max(0, row - kReach) + 1;
    for (int column = 0; column < columns; ++column) {
      const int left = std::max(0, column - kReach), right = std::min(columns - 1, column + kReach);
      int sum = 0;
      for (int at = left; at <= right; ++at) sum += sums[static_cast<std::size_t>(at)];
      means[static_cast<std::size_t>(row) * columns + column] =
          static_cast<std::uint8_t>(sum / (up * (right - left + 1)));
    }
  }
  return means;
}

void TakeMedians(LevelHeights& level) {
  if (level.columns < 3 || level.rows < 3) return;
  const std::vector<float> from = level.heights_m;
  for (int row = 1; row + 1 < level.rows; ++row) {
    MedianRow(from.data() + level.IndexOf(0, row - 1), from.data() + level.IndexOf(0, row),
              from.data() + level.IndexOf(0, row + 1), level.columns - 2,
              level.heights_m.data() + level.IndexOf(1, row));
  }
}

}  // namespace skyquilt::surface
