#include "core/surface/paths/semi_global.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdlib>
#include <opencv2/core/hal/intrin.hpp>
#include <utility>

#include "core/base/check.h"
#include "core/base/vector_clones.h"

namespace skyquilt::surface {
namespace {

using Lanes = cv::v_uint8x16;

// On both sides of a sheet lie costs that nothing takes, so that it can be read shifted by as much as it has
// heights, and one more.
constexpr int kPad = 20;
constexpr int kPaths = 4;  // of one direction through the cells; there are two
constexpr std::uint8_t kNoPath = 255;
constexpr float kFarShift = 100.0f;  // steps, in which no two sheets overlap

// By how many steps cells begin above others, rounded; no further than tells that no height is alike.
inline int ShiftOf(float low_m, float other_low_m, float per_step) {
  float steps = (low_m - other_low_m) * per_step;
  steps = steps < kFarShift ? steps : kFarShift;
  steps = steps > -kFarShift ? steps : -kFarShift;
  return static_cast<int>(steps + (steps >= 0.0f ? 0.5f : -0.5f));
}

SKYQUILT_VECTOR_CLONES void ShiftRow(const float* __restrict low_m, const float* __restrict other_low_m,
                                     float per_step, int count, std::int8_t* __restrict shifts) {
  for (int i = 0; i < count; ++i)
    shifts[i] = static_cast<std::int8_t>(ShiftOf(low_m[i], other_low_m[i], per_step));
}

// One of the four paths at a row: what it costs there and at the row before, and how the cells before on it
// lie against those of the row.
struct PathRow {
  std::vector<std::uint8_t> lanes, lanes_before;  // by cell: pad, first sheet, pad, second sheet, pad
  std::vector<std::uint8_t> least, least_before;
  std::vector<std::int8_t> shifts;  // of first sheets
  std::vector<std::uint8_t> jumps;  // what a jump costs
};

class PathSummer {
 public:
  PathSummer(const HeightSheets& sheets, const SheetCosts& costs, const std::vector<std::uint8_t>& gray,
             const JumpPenalties& penalties, SheetSums& sums)
      : columns_(sheets.columns),
        rows_(sheets.rows),
        heights_(sheets.heights),
        low_m_(sheets.low_m.data()),
        second_low_m_(sheets.second_low_m.data()),
        second_(sheets.second.data()),
        compared_(sheets.compared.data()),
        costs_(costs.first.data()),
        second_costs_(costs.second.data()),
        gray_(gray.data()),
        sums_(sums.first.data()),
        second_sums_(sums.second.data()),
        step_penalty_(static_cast<std::uint8_t>(penalties.step)),
        per_step_(1.0f / sheets.step_m),
        second_at_(2 * kPad + sheets.heights),
        stride_(second_at_ + (sheets.second_count > 0 ? kSheetHeights + kPad : 0)) {
    for (int difference = 0; difference < 256; ++difference) {
      const int lowered = std::min(difference, penalties.whole_edge) * (penalties.most - penalties.least);
      jump_[static_cast<std::size_t>(difference)] =
          static_cast<std::uint8_t>(penalties.most - lowered / std::max(1, penalties.whole_edge));
    }
    const auto columns = static_cast<std::size_t>(columns_);
    for (PathRow& path : paths_) {
      path.lanes.assign(columns * static_cast<std::size_t>(stride_), kNoPath);
      path.lanes_before = path.lanes;
      path.least.assign(columns, 0);
      path.least_before = path.least;
      path.shifts.assign(columns, 0);
      path.jumps.assign(columns, 0);
    }
  }

  // Through all rows: upwards from the first cell, which begins the sums, and downwards from the last.
  void Run(bool is_upwards) {
    const int way = is_upwards ? 1 : -1;
    for (int done = 0; done < rows_; ++done) {
      const int row = is_upwards ? done : rows_ - 1 - done;
      std::array<PathAt, kPaths> paths;
      for (std::size_t path = 0; path < kPaths; ++path) paths[path] = PrepareRow(path, row, way, done == 0);
      VisitRow(paths, row, way);
      for (PathRow& path : paths_) {
        std::swap(path.lanes, path.lanes_before);
        std::swap(path.least, path.least_before);
      }
    }
  }

 private:
  // A path at a row, and the row of the cells before: that of a cell lies `back` columns beside it.
  struct PathAt {
    std::uint8_t *lanes = nullptr, *least = nullptr;
    int back = 0, first = 0, last = -1;  // columns that have a cell before
    const std::uint8_t *lanes_before = nullptr, *least_before = nullptr, *jumps = nullptr;
    const std::int8_t* shifts = nullptr;
    const std::int32_t* second_before = nullptr;
    const float *low_m_before = nullptr, *second_low_m_before = nullptr;
  };

  PathAt PrepareRow(std::size_t path, int row, int way, bool is_first_row) {
    constexpr std::array<int, kPaths> kBack = {-1, -1, 0, 1};
    PathRow& here = paths_[path];
    PathAt at;
    at.lanes = here.lanes.data();
    at.least = here.least.data();
    if (path != 0 && is_first_row) return at;
    const int back = way * kBack[path];
    const ColumnSpan own_span = compared_[row], before = compared_[path == 0 ? row : row - way];
    at.first = std::max(own_span.first, before.first - back);
    at.last = std::min(own_span.end, before.end - back) - 1;
    if (at.first > at.last) return at;
    // The path along the row reads what this row has written; the others the row before.
    at.back = back;
    at.lanes_before = (path == 0 ? here.lanes : here.lanes_before).data();
    at.least_before = (path == 0 ? here.least : here.least_before).data();
    const std::ptrdiff_t own = static_cast<std::ptrdiff_t>(row) * columns_,
                         other = static_cast<std::ptrdiff_t>(path == 0 ? row : row - way) * columns_;
    at.second_before = second_ + other;
    at.low_m_before = low_m_ + other;
    at.second_low_m_before = second_low_m_ + other;
    ShiftRow(low_m_ + own + at.first, at.low_m_before + at.first + back, per_step_, at.last - at.first + 1,
             here.shifts.data() + at.first);
    for (int column = at.first; column <= at.last; ++column) {
      here.jumps.data()[column] = jump_.data()[std::abs(gray_[own + column] - gray_[other + column + back])];
    }
    at.shifts = here.shifts.data();
    at.jumps = here.jumps.data();
    return at;
  }

  static Lanes Cheaper(Lanes best, const std::uint8_t* lanes, int shift, Lanes step) {
    if (shift < -kSheetHeights || shift > kSheetHeights) return best;
    lanes += shift;
    return cv::v_min(
        best, cv::v_min(cv::v_load(lanes), cv::v_min(cv::v_load(lanes - 1), cv::v_load(lanes + 1)) + step));
  }

  // Paths by value: what a path writes could be any of their pointers, as far as the compiler knows.
  void VisitRow(const std::array<PathAt, kPaths> paths, int row, int way) {
    const std::ptrdiff_t row_at = static_cast<std::ptrdiff_t>(row) * columns_;
    const std::int32_t* const seconds = second_ + row_at;
    const float *const low_m = low_m_ + row_at, *const second_low_m = second_low_m_ + row_at;
    const ColumnSpan span = compared_[row];
    const int heights = heights_, second_at = second_at_, stride = stride_;
    const std::uint8_t *const costs = costs_ + row_at * heights, *const second_costs = second_costs_;
    std::uint16_t *const sums = sums_ + row_at * heights, *const second_sums = second_sums_;
    const Lanes step = cv::v_setall_u8(step_penalty_);
    const float per_step = per_step_;
    const bool begins = way > 0;
    for (int passed = 0; passed < span.end - span.first; ++passed) {
      const int column = begins ? span.first + passed : span.end - 1 - passed;
      const std::ptrdiff_t at_cell = static_cast<std::ptrdiff_t>(column) * stride;
      const std::int32_t second = seconds[column];
      std::array<Lanes, kPaths> least;
      for (Lanes& lanes : least) lanes = cv::v_setall_u8(kNoPath);
      // kSheetHeights heights of one of the cell's sheets, along all four paths.
      const auto visit = [&](const std::uint8_t* cost, std::uint16_t* sum, int at, int to, bool is_second) {
        const Lanes own = cv::v_load(cost);
        cv::v_uint16x8 low = cv::v_setzero_u16(), high = cv::v_setzero_u16();
        if (!begins) {
          low = cv::v_load(sum);
          high = cv::v_load(sum + 8);
        }
        for (std::size_t p = 0; p < kPaths; ++p) {
          const PathAt& path = paths[p];
          Lanes here = own;
          if (column >= path.first && column <= path.last) {
            const int from = column + path.back;
            const std::uint8_t* lanes = path.lanes_before + static_cast<std::ptrdiff_t>(from) * stride;
            const Lanes least_before = cv::v_setall_u8(path.least_before[from]);
            const float own_m = is_second ? second_low_m[column] : low_m[column];
            Lanes best = Cheaper(
                least_before + cv::v_setall_u8(path.jumps[column]), lanes + kPad + at,
                is_second ? ShiftOf(own_m, path.low_m_before[from], per_step) : path.shifts[column], step);
            if (path.second_before[from] != HeightSheets::kNone) {
              best = Cheaper(best, lanes + second_at,
                             ShiftOf(own_m, path.second_low_m_before[from], per_step), step);
            }
            here = own + (best - least_before);
          }
          cv::v_store(path.lanes + at_cell + to, here);
          least[p] = cv::v_min(least[p], here);
          cv::v_uint16x8 wide_low, wide_high;
          cv::v_expand(here, wide_low, wide_high);
          low += wide_low;
          high += wide_high;
        }
        cv::v_store(sum, low);
        cv::v_store(sum + 8, high);
      };
      for (int at = 0; at < heights; at += kSheetHeights) {
        const std::ptrdiff_t from = static_cast<std::ptrdiff_t>(column) * heights + at;
        visit(costs + from, sums + from, at, kPad + at, false);
      }
      if (second != HeightSheets::kNone) {
        const std::ptrdiff_t from = static_cast<std::ptrdiff_t>(second) * kSheetHeights;
        visit(second_costs + from, second_sums + from, 0, second_at, true);
      }
      for (std::size_t p = 0; p < kPaths; ++p) paths[p].least[column] = cv::v_reduce_min(least[p]);
    }
  }

  // Pointers, because what is looked up here is so a hundred times a cell.
  const int columns_, rows_, heights_;
  const float *low_m_, *second_low_m_;
  const std::int32_t* second_;
  const ColumnSpan* compared_;
  const std::uint8_t *costs_, *second_costs_, *gray_;
  std::uint16_t *sums_, *second_sums_;
  const std::uint8_t step_penalty_;
  const float per_step_;
  const int second_at_, stride_;
  std::array<std::uint8_t, 256> jump_;
  std::array<PathRow, kPaths> paths_;
};

}  // namespace

void SumAlongPaths(const HeightSheets& sheets, const SheetCosts& costs, const std::vector<std::uint8_t>& gray,
                   const JumpPenalties& penalties, SheetSums& sums) {
  SKYQUILT_CHECK(sheets.second_count == 0 || sheets.heights == kSheetHeights,
                 "second sheets follow short ones");
  sums.first.resize(sheets.Cells() * static_cast<std::size_t>(sheets.heights));
  sums.second.resize(static_cast<std::size_t>(sheets.second_count) * kSheetHeights);
  PathSummer summer(sheets, costs, gray, penalties, sums);
  summer.Run(true);
  summer.Run(false);
}

}  // namespace skyquilt::surface
