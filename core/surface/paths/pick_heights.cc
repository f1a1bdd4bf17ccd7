#include "core/surface/paths/pick_heights.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <opencv2/core/hal/intrin.hpp>

namespace skyquilt::surface {
namespace {

constexpr std::uint16_t kNoSum = std::numeric_limits<std::uint16_t>::max();
constexpr int kAroundLeast = 2;  // steps that are one minimum
// Cells whose costs say what lies between steps: nine, whose pictures overlap little.
constexpr int kCurveReach = 3, kCurveStep = 3;
// Neighbours further off than this lie on something else.
constexpr float kSameSurfaceSteps = 1.5f;
constexpr int kCostsAround = 3;  // one beyond those

struct Winner {
  std::uint16_t sum = kNoSum;
  int at = 0;
};

// What was taken at a cell.
struct Taken {
  float low_steps = 0.0f;  // of its sheet
  std::int16_t at = 0, count = 0;
  std::array<std::uint8_t, 2 * kCostsAround + 1> costs{};  // about `at`, where the sheet has heights
};

using Sums = cv::v_uint16x8;
static_assert(kSheetHeights == 16, "a sheet is two vectors of sums");

// Of a whole number of sheets' heights.
Winner LeastOf(const std::uint16_t* sums, int count) {
  Sums least = cv::v_setall_u16(kNoSum);
  for (int at = 0; at < count; at += 8) least = cv::v_min(least, cv::v_load(sums + at));
  const std::uint16_t sum = cv::v_reduce_min(least);
  const Sums wanted = cv::v_setall_u16(sum);
  int at = 0;
  while (!cv::v_check_any(cv::v_load(sums + at) == wanted)) at += 8;
  while (sums[at] != sum) ++at;
  return {sum, at};
}

// The least beyond kAroundLeast of `at`, which may lie outside.
std::uint16_t LeastBeyond(const std::uint16_t* sums, int count, int at) {
  const auto low = static_cast<std::int16_t>(std::clamp(at, -1000, 1000) - kAroundLeast);
  const cv::v_int16x8 below = cv::v_setall_s16(low),
                      above = cv::v_setall_s16(static_cast<std::int16_t>(low + 2 * kAroundLeast)),
                      next = cv::v_setall_s16(8);
  cv::v_int16x8 here(0, 1, 2, 3, 4, 5, 6, 7);
  Sums least = cv::v_setall_u16(kNoSum);
  for (int from = 0; from < count; from += 8) {
    const cv::v_int16x8 is_beyond = (here < below) | (here > above);
    least = cv::v_min(least, cv::v_load(sums + from) | cv::v_reinterpret_as_u16(~is_beyond));
    here += next;
  }
  return cv::v_reduce_min(least);
}

Taken TakenOf(const std::uint8_t* costs, int count, float low_steps, int at) {
  Taken taken{low_steps, static_cast<std::int16_t>(at), static_cast<std::int16_t>(count), {}};
  const int first = std::max(0, at - kCostsAround), last = std::min(count - 1, at + kCostsAround);
  std::copy(costs + first, costs + last + 1, taken.costs.data() + (first - at + kCostsAround));
  return taken;
}

std::uint8_t ContrastOf(const std::uint8_t* costs, int count, int at) {
  int sum = 0;
  for (int i = 0; i < count; ++i) sum += costs[i];
  return static_cast<std::uint8_t>(std::max(0, sum / count - costs[at]));
}

// How far from the height taken, in steps, the cell and those around it have their least cost.
float BetweenSteps(const HeightSheets& sheets, const Taken* taken, int column, int row) {
  const Taken& own = taken[static_cast<std::size_t>(row) * sheets.columns + column];
  const float own_steps = own.low_steps + own.at;
  int below = 0, here = 0, above = 0;
  for (int y = std::max(0, row - kCurveReach); y <= std::min(sheets.rows - 1, row + kCurveReach);
       y += kCurveStep) {
    for (int x = std::max(0, column - kCurveReach); x <= std::min(sheets.columns - 1, column + kCurveReach);
         x += kCurveStep) {
      const Taken& other = taken[static_cast<std::size_t>(y) * sheets.columns + x];
      if (std::abs(other.low_steps + other.at - own_steps) > kSameSurfaceSteps) continue;
      const int at = static_cast<int>(own_steps - other.low_steps + 0.5f);
      if (at < 1 || at + 1 >= other.count) continue;
      const std::uint8_t* costs = other.costs.data() + kCostsAround + (at - other.at);
      below += costs[-1];
      here += costs[0];
      above += costs[1];
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
  const float per_step = 1.0f / sheets.step_m;
  const float *low_m = sheets.low_m.data(), *second_low_m = sheets.second_low_m.data();
  const std::int32_t* seconds = sheets.second.data();
  Taken* const taken_at = all_taken.data();
  for (std::size_t cell = 0; cell < sheets.Cells(); ++cell) {
    const std::size_t from = cell * static_cast<std::size_t>(heights);
    const std::uint16_t* first = sums.first.data() + from;
    Winner winner = LeastOf(first, heights);
    const std::uint8_t* own_costs = costs.first.data() + from;
    int own_count = heights;
    float own_low_m = low_m[cell];
    const std::int32_t second = seconds[cell];
    std::uint16_t others = kNoSum;
    if (second == HeightSheets::kNone) {
      others = LeastBeyond(first, heights, winner.at);
    } else {
      const std::size_t from_second = static_cast<std::size_t>(second) * kSheetHeights;
      const std::uint16_t* upper = sums.second.data() + from_second;
      const Winner in_upper = LeastOf(upper, kSheetHeights);
      const float between = (second_low_m[cell] - low_m[cell]) / sheets.step_m;
      const int apart = static_cast<int>(std::min(between, 10000.0f) + 0.5f);
      int at_in_first = winner.at;
      if (in_upper.sum < winner.sum) {
        winner = in_upper;
        at_in_first = winner.at + apart;
        own_costs = costs.second.data() + from_second;
        own_count = kSheetHeights;
        own_low_m = second_low_m[cell];
      }
      others = std::min(LeastBeyond(first, kSheetHeights, at_in_first),
                        LeastBeyond(upper, kSheetHeights, at_in_first - apart));
    }
    picked.margins.data()[cell] = static_cast<std::uint16_t>(std::max(0, others - winner.sum));
    picked.contrasts.data()[cell] = ContrastOf(own_costs, own_count, winner.at);
    taken_at[cell] = TakenOf(own_costs, own_count, own_low_m * per_step, winner.at);
  }
  std::size_t cell = 0;
  for (int row = 0; row < sheets.rows; ++row) {
    for (int column = 0; column < sheets.columns; ++column, ++cell) {
      const Taken& taken = taken_at[cell];
      const float steps =
          taken.low_steps + static_cast<float>(taken.at) + BetweenSteps(sheets, taken_at, column, row);
      picked.heights_m.data()[cell] = sheets.step_m * steps;
    }
  }
  return picked;
}

}  // namespace skyquilt::surface
