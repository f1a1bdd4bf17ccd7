#include "core/surface/refine/alike_heights.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdlib>

#include "core/base/vector_clones.h"

namespace skyquilt::surface {
namespace {

// Parts of `within_m` that heights are told apart by, as whole numbers of 16 bits: twice as many cells at a
// time as in floats.
constexpr float kAlikeParts = 8.0f;
constexpr std::int16_t kBeyondBorder = 32000;
constexpr float kFarthest = 15000.0f;

SKYQUILT_VECTOR_CLONES void AddAlike(const std::int16_t* __restrict own, const std::int16_t* __restrict other,
                                     int count, std::int16_t* __restrict alike) {
  constexpr std::int16_t kWithin = static_cast<std::int16_t>(kAlikeParts);
  for (int i = 0; i < count; ++i) {
    const auto off = static_cast<std::int16_t>(own[i] - other[i]);
    const bool is_alike = off <= kWithin && off >= -kWithin;
    alike[i] = static_cast<std::int16_t>(alike[i] + (is_alike ? 1 : 0));
  }
}

}  // namespace

std::vector<std::uint8_t> CountAlike(const LevelHeights& level, float within_m) {
  std::vector<std::uint8_t> counts(level.heights_m.size(), 0);
  if (level.heights_m.empty()) return counts;
  const std::size_t stride = static_cast<std::size_t>(level.columns) + 2 * kAlikeReach;
  const float middle_m = level.heights_m[level.heights_m.size() / 2], scale = kAlikeParts / within_m;
  std::vector<std::int16_t> padded(stride * (static_cast<std::size_t>(level.rows) + 2 * kAlikeReach),
                                   kBeyondBorder);
  for (int row = 0; row < level.rows; ++row) {
    const float* from = level.heights_m.data() + level.IndexOf(0, row);
    std::int16_t* to = padded.data() + (static_cast<std::size_t>(row) + kAlikeReach) * stride + kAlikeReach;
    for (int column = 0; column < level.columns; ++column) {
      to[column] =
          static_cast<std::int16_t>(std::clamp((from[column] - middle_m) * scale, -kFarthest, kFarthest));
    }
  }
  std::vector<std::int16_t> alike(static_cast<std::size_t>(level.columns));
  for (int row = 0; row < level.rows; ++row) {
    std::fill(alike.begin(), alike.end(), std::int16_t{-1});  // not the cell itself
    const std::int16_t* own =
        padded.data() + (static_cast<std::size_t>(row) + kAlikeReach) * stride + kAlikeReach;
    for (int y = 0; y <= 2 * kAlikeReach; ++y) {
      const std::int16_t* other = padded.data() + static_cast<std::size_t>(row + y) * stride;
      for (int x = 0; x <= 2 * kAlikeReach; ++x) AddAlike(own, other + x, level.columns, alike.data());
    }
    std::transform(alike.begin(), alike.end(),
                   counts.begin() + static_cast<std::ptrdiff_t>(level.IndexOf(0, row)),
                   [](std::int16_t count) { return static_cast<std::uint8_t>(count); });
  }
  return counts;
}

void DropSpeckles(LevelHeights& level, const std::vector<std::uint8_t>& alike,
                  const std::vector<std::uint8_t>& agreeing, const SpeckleRules& rules) {
  constexpr std::array<std::array<int, 2>, 4> kBeside = {{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};
  constexpr std::uint8_t kUnmet = 1, kMet = 2, kDropped = 3;
  std::vector<std::size_t> members;
  for (std::size_t start = 0; start < level.is_known.size(); ++start) {
    if (level.is_known[start] != kUnmet || alike[start] < rules.many) continue;
    members.assign(1, start);
    level.is_known[start] = kMet;
    std::size_t own = 0, weight = 0, smooth = 0;
    for (std::size_t next = 0; next < members.size(); ++next) {
      const std::size_t cell = members[next];
      if (alike[cell] >= rules.many) {
        ++own;
        weight += 1 + rules.third_photo * static_cast<std::size_t>(std::max(0, agreeing[cell] - 2));
      }
      smooth += alike[cell] >= rules.most ? 1 : 0;
      const int column = static_cast<int>(cell % static_cast<std::size_t>(level.columns)),
                row = static_cast<int>(cell / static_cast<std::size_t>(level.columns));
      for (const auto& [step_x, step_y] : kBeside) {
        const int x = column + step_x, y = row + step_y;
        if (x < 0 || y < 0 || x >= level.columns || y >= level.rows) continue;
        const std::size_t other = level.IndexOf(x, y);
        if (level.is_known[other] != kUnmet || alike[other] < rules.some) continue;
        if (std::abs(level.heights_m[other] - level.heights_m[cell]) > rules.most_step_m) continue;
        level.is_known[other] = kMet;
        members.push_back(other);
      }
    }
    const bool is_borne_out = weight >= rules.least_weight || 2 * smooth >= members.size();
    if (own >= rules.least_cells && is_borne_out) continue;
    for (const std::size_t cell : members) level.is_known[cell] = kDropped;
  }
  for (std::uint8_t& known : level.is_known) known = known == kMet ? 1 : 0;
}

}  // namespace skyquilt::surface
