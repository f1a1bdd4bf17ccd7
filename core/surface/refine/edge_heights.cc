#include "core/surface/refine/edge_heights.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdlib>

namespace skyquilt::surface {
namespace {

constexpr int kEdgeWindow = 5;  // cells: further than a census window spreads a step
constexpr int kNearStep = 4;    // within which a step concerns a cell
constexpr float kLikeGray = 10.0f;
constexpr float kNearCells = 4.0f;
constexpr float kVoteCost = 32.0f;     // what a vote of all weighs against the photos' costs
constexpr float kFilledTrust = 0.25f;  // of what was not measured
constexpr int kSide = 2 * kEdgeWindow + 1;

using Window = std::array<float, kSide * kSide>;

std::vector<std::uint8_t> CellsNearSteps(const LevelHeights& level, float step_m) {
  std::vector<std::uint8_t> is_near(level.heights_m.size(), 0);
  for (int row = 0; row < level.rows; ++row) {
    for (int column = 0; column < level.columns; ++column) {
      const float here_m = level.heights_m[level.IndexOf(column, row)];
      const bool steps = (column + 1 < level.columns &&
                          std::abs(level.heights_m[level.IndexOf(column + 1, row)] - here_m) > step_m) ||
                         (row + 1 < level.rows &&
                          std::abs(level.heights_m[level.IndexOf(column, row + 1)] - here_m) > step_m);
      if (!steps) continue;
      for (int y = std::max(0, row - kNearStep + 1); y <= std::min(level.rows - 1, row + kNearStep); ++y) {
        const int left = std::max(0, column - kNearStep + 1),
                  right = std::min(level.columns - 1, column + kNearStep);
        std::fill(is_near.begin() + static_cast<std::ptrdiff_t>(level.IndexOf(left, y)),
                  is_near.begin() + static_cast<std::ptrdiff_t>(level.IndexOf(right, y)) + 1,
                  std::uint8_t{1});
      }
    }
  }
  return is_near;
}

}  // namespace

OtherSides FindOtherSides(const LevelHeights& level, const std::vector<std::uint8_t>& gray, float step_m) {
  const std::vector<std::uint8_t> is_near = CellsNearSteps(level, step_m);
  std::array<float, 256> like;
  for (std::size_t i = 0; i < like.size(); ++i) like[i] = std::exp(-static_cast<float>(i) / kLikeGray);
  Window near;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const int along = x - kEdgeWindow, up = y - kEdgeWindow;
      near[static_cast<std::size_t>(y * kSide + x)] =
          std::exp(-0.5f * static_cast<float>(along * along + up * up) / (kNearCells * kNearCells));
    }
  }
  const std::vector<float>& from = level.heights_m;
  OtherSides sides{from, std::vector<float>(from.size(), 1.0f)};
  Window heights, weights;
  float *const window_m = heights.data(), *const window_weights = weights.data();
  for (int row = kEdgeWindow; row + kEdgeWindow < level.rows; ++row) {
    for (int column = kEdgeWindow; column + kEdgeWindow < level.columns; ++column) {
      const std::size_t cell = level.IndexOf(column, row);
      if (is_near[cell] == 0) continue;
      const float own_m = from[cell];
      float lowest = own_m, highest = own_m;
      for (int y = 0; y < kSide; ++y) {
        const std::size_t first = level.IndexOf(column - kEdgeWindow, row - kEdgeWindow + y);
        const float *others_m = from.data() + first, *nearness = near.data() + y * kSide;
        const std::uint8_t *grays = gray.data() + first, *known = level.is_known.data() + first;
        for (int x = 0; x < kSide; ++x) {
          const float other_m = others_m[x];
          lowest = std::min(lowest, other_m);
          highest = std::max(highest, other_m);
          window_m[y * kSide + x] = other_m;
          window_weights[y * kSide + x] = nearness[x] * like.data()[std::abs(gray[cell] - grays[x])] *
                                          (known[x] != 0 ? 1.0f : kFilledTrust);
        }
      }
      if (highest - lowest <= step_m) continue;
      const float middle = 0.5f * (lowest + highest);
      const bool is_upper = own_m > middle;
      float own = 0.0f, others = 0.0f;
      int most_like = 0;
      float most = -1.0f;
      for (int i = 0; i < kSide * kSide; ++i) {
        const float weight = window_weights[i];
        if ((window_m[i] > middle) == is_upper) {
          own += weight;
          continue;
        }
        others += weight;
        if (weight <= most) continue;
        most = weight;
        most_like = i;
      }
      sides.heights_m[cell] = window_m[most_like];
      sides.votes[cell] = (own - others) / (own + others);
    }
  }
  return sides;
}

void TakeBetterSides(const OtherSides& sides, const std::vector<std::int16_t>& worse, LevelHeights& level) {
  const std::vector<float> from = level.heights_m;
  for (int row = 1; row + 1 < level.rows; ++row) {
    for (int column = 1; column + 1 < level.columns; ++column) {
      const std::size_t cell = level.IndexOf(column, row);
      const float up_m = sides.heights_m[cell] - from[cell];
      if (up_m == 0.0f) continue;
      int sum = 0, count = 0;
      for (int y = row - 1; y <= row + 1; ++y) {
        for (int x = column - 1; x <= column + 1; ++x) {
          const std::size_t other = level.IndexOf(x, y);
          if ((sides.heights_m[other] - from[other]) * up_m <= 0.0f) continue;
          sum += worse[other];
          ++count;
        }
      }
      const float costs = static_cast<float>(sum) / static_cast<float>(count);
      if (costs + kVoteCost * sides.votes[cell] < 0.0f) level.heights_m[cell] = sides.heights_m[cell];
    }
  }
}

}  // namespace skyquilt::surface
