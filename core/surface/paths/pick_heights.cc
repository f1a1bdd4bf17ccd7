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

struct Winner {
  std::uint16_t sum = kNoSum;
  int at = 0;
};

// What was taken at a cell; its own cost among those of its sheet.
struct Taken {
  float low_steps = 0.0f;  // of its sheet
  std::int16_t at = 0, count = 0;
  const std::uint8_t* cost = nullptr;
};

static_assert(kSheetHeights == 16, "a sheet is two vectors of sums, and where one lies has four bits");
static_assert(8 * kMaxPathCost < 1 << 11, "a sum over eight paths, and where it is, have fifteen bits");

// Of a whole number of sheets' heights.
Winner LeastOf(const std::uint16_t* sums, int count) {
  const cv::v_int16x8 low_at(0, 1, 2, 3, 4, 5, 6, 7), high_at(8, 9, 10, 11, 12, 13, 14, 15);
  Winner winner;
  for (int from = 0; from < count; from += kSheetHeights) {
    const auto with_place = [&](int first, const cv::v_int16x8& at) {
      return cv::v_shl<4>(cv::v_reinterpret_as_s16(cv::v_load(sums + from + first))) | at;
    };
    const int least = cv::v_reduce_min(cv::v_min(with_place(0, low_at), with_place(8, high_at)));
    if (least >> 4 < winner.sum) winner = {static_cast<std::uint16_t>(least >> 4), from + (least & 15)};
  }
  return winner;
}

// For LeastBeyond: the bits of a sheet's sums that do not count are set, read from where `at` is in the
// middle.
constexpr int kMiddle = 20;
constexpr std::array<std::int16_t, 2 * kMiddle> kNear = [] {
  std::array<std::int16_t, 2 * kMiddle> near{};
  for (int i = kMiddle - kAroundLeast; i <= kMiddle + kAroundLeast; ++i)
    near[static_cast<std::size_t>(i)] = std::numeric_limits<std::int16_t>::max();
  return near;
}();

// The least beyond kAroundLeast of `at`, which may lie outside.
std::uint16_t LeastBeyond(const std::uint16_t* sums, int count, int at) {
  cv::v_int16x8 least = cv::v_setall_s16(std::numeric_limits<std::int16_t>::max());
  for (int from = 0; from < count; from += kSheetHeights) {
    const int of_sheet = std::clamp(at - from, -kAroundLeast - 1, kSheetHeights + kAroundLeast);
    const std::int16_t* near = kNear.data() + kMiddle - of_sheet;
    for (int first = 0; first < kSheetHeights; first += 8) {
      least = cv::v_min(least,
                        cv::v_reinterpret_as_s16(cv::v_load(sums + from + first)) | cv::v_load(near + first));
    }
  }
  return static_cast<std::uint16_t>(cv::v_reduce_min(least));
}

std::uint8_t ContrastOf(const std::uint8_t* costs, int count, int at) {
  unsigned sum = 0;
  for (int from = 0; from < count; from += kSheetHeights) sum += cv::v_reduce_sum(cv::v_load(costs + from));
  return static_cast<std::uint8_t>(std::max(0, static_cast<int>(sum) / count - costs[at]));
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
      const std::uint8_t* costs = other.cost + (at - other.at);
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
  picked.heights_m = sheets.expected_m;
  picked.margins.resize(sheets.Cells());
  picked.contrasts.resize(sheets.Cells());
  std::vector<Taken> all_taken(sheets.Cells());
  const int heights = sheets.heights;
  const float per_step = 1.0f / sheets.step_m;
  const float *low_m = sheets.low_m.data(), *second_low_m = sheets.second_low_m.data();
  const std::int32_t* seconds = sheets.second.data();
  Taken* const taken_at = all_taken.data();
  const auto pick = [&](std::size_t cell) {
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
    taken_at[cell] = {own_low_m * per_step, static_cast<std::int16_t>(winner.at),
                      static_cast<std::int16_t>(own_count), own_costs + winner.at};
  };
  const auto for_compared = [&](const auto& visit) {
    for (int row = 0; row < sheets.rows; ++row) {
      const ColumnSpan span = sheets.compared[static_cast<std::size_t>(row)];
      for (int column = span.first; column < span.end; ++column)
        visit(column, row, static_cast<std::size_t>(row) * sheets.columns + column);
    }
  };
  for_compared([&](int, int, std::size_t cell) { pick(cell); });
  for_compared([&](int column, int row, std::size_t cell) {
    const Taken& taken = taken_at[cell];
    const float steps =
        taken.low_steps + static_cast<float>(taken.at) + BetweenSteps(sheets, taken_at, column, row);
    picked.heights_m.data()[cell] = sheets.step_m * steps;
  });
  return picked;
}

}  // namespace skyquilt::surface
