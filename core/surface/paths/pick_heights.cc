#include "core/surface/paths/pick_heights.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <type_traits>

namespace skyquilt::surface {
namespace {

constexpr std::uint16_t kNoSum = std::numeric_limits<std::uint16_t>::max();
constexpr int kAroundLeast = 2;  // steps that are one minimum
// Cells whose costs say what lies between steps: nine, whose pictures overlap little.
constexpr int kCurveReach = 3, kCurveStep = 3;
// Neighbours further off than this lie on something else.
constexpr float kSameSurfaceSteps = 1.5f;

struct Winner {
  std::uint16_t sum = kNoSum;
  int at = 0;
};

// What was taken at a cell.
struct Taken {
  const std::uint8_t* costs = nullptr;  // of its sheet
  float low_m = 0.0f;                   // of that sheet
  std::int16_t at = 0;
  std::int16_t count = 0;
};

// With a number of heights that the compiler knows, the usual one, these are a few vector instructions.
template <typename Count>
Winner LeastOf(const std::uint16_t* sums, Count count) {
  std::uint16_t least = kNoSum;
  for (int i = 0; i < count; ++i) least = std::min(least, sums[i]);
  return {least, static_cast<int>(std::find(sums, sums + count, least) - sums)};
}

// The least beyond kAroundLeast of `at`, which may lie outside.
template <typename Count>
std::uint16_t LeastBeyond(const std::uint16_t* sums, Count count, int at) {
  std::uint16_t least = kNoSum;
  const auto low = static_cast<std::int16_t>(std::clamp(at, -1000, 1000) - kAroundLeast),
             high = static_cast<std::int16_t>(low + 2 * kAroundLeast);
  for (int i = 0; i < count; ++i) {
    const auto here = static_cast<std::int16_t>(i);
    least = std::min(least, here < low || here > high ? sums[i] : kNoSum);
  }
  return least;
}

std::uint8_t ContrastOf(const Taken& taken) {
  int sum = 0;
  for (int i = 0; i < taken.count; ++i) sum += taken.costs[i];
  return static_cast<std::uint8_t>(std::max(0, sum / taken.count - taken.costs[taken.at]));
}

// How far from the height taken, in steps, the cell and those around it have their least cost.
float BetweenSteps(const HeightSheets& sheets, const std::vector<Taken>& taken, int column, int row) {
  const float per_step = 1.0f / sheets.step_m;
  const Taken& own = taken[static_cast<std::size_t>(row) * sheets.columns + column];
  const float own_steps = own.low_m * per_step + own.at;
  int below = 0, here = 0, above = 0;
  for (int y = std::max(0, row - kCurveReach); y <= std::min(sheets.rows - 1, row + kCurveReach);
       y += kCurveStep) {
    for (int x = std::max(0, column - kCurveReach); x <= std::min(sheets.columns - 1, column + kCurveReach);
         x += kCurveStep) {
      const Taken& other = taken[static_cast<std::size_t>(y) * sheets.columns + x];
      const float other_low = other.low_m * per_step;
      if (std::abs(other_low + other.at - own_steps) > kSameSurfaceSteps) continue;
      const int at = static_cast<int>(own_steps - other_low + 0.5f);
      if (at < 1 || at + 1 >= other.count) continue;
      below += other.costs[at - 1];
      here += other.costs[at];
      above += other.costs[at + 1];
    }
  }
  // Census costs rise on both sides like a V, which a parabola would draw towards the step.
  const int rise = std::max(below, above) - here;
  if (rise <= 0) return 0.0f;
  return std::clamp(0.5f * static_cast<float>(below - above) / static_cast<float>(rise), -1.0f, 1.0f);
}

}  // namespace

PickedHeights PickHeights(const HeightSheets& sheets, const SheetCosts& costs, const SheetSums& sums) {
  PickedHeights picked;
  picked.heights_m.resize(sheets.Cells());
  picked.margins.resize(sheets.Cells());
  picked.contrasts.resize(sheets.Cells());
  std::vector<Taken> all_taken(sheets.Cells());
  const int heights = sheets.heights;
  constexpr std::integral_constant<int, kSheetHeights> kShort;
  const bool is_short = heights == kShort;
  for (std::size_t cell = 0; cell < sheets.Cells(); ++cell) {
    const std::size_t from = cell * static_cast<std::size_t>(heights);
    const std::uint16_t* first = sums.first.data() + from;
    Winner winner = is_short ? LeastOf(first, kShort) : LeastOf(first, heights);
    Taken& taken = all_taken[cell];
    taken = {costs.first.data() + from, sheets.low_m[cell], static_cast<std::int16_t>(winner.at),
             static_cast<std::int16_t>(heights)};
    const std::int32_t second = sheets.second[cell];
    std::uint16_t others = kNoSum;
    if (second == HeightSheets::kNone) {
      others = is_short ? LeastBeyond(first, kShort, winner.at) : LeastBeyond(first, heights, winner.at);
    } else {
      const std::size_t from_second = static_cast<std::size_t>(second) * kSheetHeights;
      const std::uint16_t* upper = sums.second.data() + from_second;
      const Winner in_upper = LeastOf(upper, kShort);
      const float between = (sheets.second_low_m[cell] - sheets.low_m[cell]) / sheets.step_m;
      const int apart = static_cast<int>(std::min(between, 10000.0f) + 0.5f);
      int at_in_first = winner.at;
      if (in_upper.sum < winner.sum) {
        winner = in_upper;
        at_in_first = winner.at + apart;
        taken = {costs.second.data() + from_second, sheets.second_low_m[cell],
                 static_cast<std::int16_t>(winner.at), kSheetHeights};
      }
      others =
          std::min(LeastBeyond(first, kShort, at_in_first), LeastBeyond(upper, kShort, at_in_first - apart));
    }
    picked.margins[cell] = static_cast<std::uint16_t>(std::max(0, others - winner.sum));
    picked.contrasts[cell] = ContrastOf(taken);
  }
  std::size_t cell = 0;
  for (int row = 0; row < sheets.rows; ++row) {
    for (int column = 0; column < sheets.columns; ++column, ++cell) {
      const Taken& taken = all_taken[cell];
      const float steps = static_cast<float>(taken.at) + BetweenSteps(sheets, all_taken, column, row);
      picked.heights_m[cell] = taken.low_m + sheets.step_m * steps;
    }
  }
  return picked;
}

}  // namespace skyquilt::surface
