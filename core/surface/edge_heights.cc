#include "core/surface/edge_heights.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdlib>

namespace skyquilt::surface {
namespace {

constexpr int kReach = 4;     // cells: as far as a census window spreads a step
constexpr int kNearStep = 3;  // cells within which a step concerns a cell
constexpr float kLikeGray = 10.0f;
constexpr float kNearCells = 3.0f;

constexpr int kSide = 2 * kReach + 1;

struct Voice {
  float height_m = 0.0f;
  float weight = 0.0f;
};

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

void MoveStepsToEdges(const std::vector<std::uint8_t>& gray, float step_m, LevelHeights& level) {
  const std::vector<std::uint8_t> is_near = CellsNearSteps(level, step_m);
  std::array<float, 256> like;
  for (std::size_t i = 0; i < like.size(); ++i) like[i] = std::exp(-static_cast<float>(i) / kLikeGray);
  std::array<float, kSide * kSide> near;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const float square = static_cast<float>((x - kReach) * (x - kReach) + (y - kReach) * (y - kReach));
      near[static_cast<std::size_t>(y * kSide + x)] = std::exp(-0.5f * square / (kNearCells * kNearCells));
    }
  }
  const std::vector<float> from = level.heights_m;
  std::array<Voice, kSide * kSide> voices;
  for (int row = kReach; row + kReach < level.rows; ++row) {
    for (int column = kReach; column + kReach < level.columns; ++column) {
      const std::size_t cell = level.IndexOf(column, row);
      if (is_near[cell] == 0) continue;
      float all = 0.0f;
      std::size_t count = 0;
      for (int y = -kReach; y <= kReach; ++y) {
        for (int x = -kReach; x <= kReach; ++x, ++count) {
          const std::size_t other = level.IndexOf(column + x, row + y);
          const float trust = level.is_known[other] != 0 ? 1.0f : 0.25f;
          const float weight =
              trust * near[count] * like[static_cast<std::size_t>(std::abs(gray[cell] - gray[other]))];
          voices[count] = {from[other], weight};
          all += weight;
        }
      }
      std::sort(voices.begin(), voices.end(),
                [](const Voice& a, const Voice& b) { return a.height_m < b.height_m; });
      float sum = 0.0f;
      for (const Voice& voice : voices) {
        sum += voice.weight;
        if (sum < 0.5f * all) continue;
        level.heights_m[cell] = voice.height_m;
        break;
      }
    }
  }
}

}  // namespace skyquilt::surface
