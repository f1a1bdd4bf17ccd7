#include "core/surface/paths/semi_global.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <opencv2/core/hal/intrin.hpp>

#include "core/base/check.h"

namespace skyquilt::surface {
namespace {

using Lanes = cv::v_uint8x16;

// On both sides of a sheet lie costs that nothing takes, so that it can be read shifted by as much as it has
// heights, and one more.
constexpr int kPad = 20;
constexpr int kPaths = 4;  // of one direction through the cells; there are two
constexpr std::uint8_t kNoPath = 255;

// The path costs of one row for one of the four paths.
struct PathRow {
  std::vector<std::uint8_t> lanes;  // by cell: pad, first sheet, pad, second sheet, pad
  std::vector<std::uint8_t> least;
};

class PathSummer {
 public:
  PathSummer(const HeightSheets& sheets, const SheetCosts& costs, const std::vector<std::uint8_t>& gray,
             const JumpPenalties& penalties, SheetSums& sums)
      : sheets_(sheets),
        costs_(costs),
        gray_(gray),
        sums_(sums),
        step_penalty_(static_cast<std::uint8_t>(penalties.step)),
        per_step_(1.0f / sheets.step_m),
        second_at_(2 * kPad + sheets.heights),
        stride_(second_at_ + (sheets.second_count > 0 ? kSheetHeights + kPad : 0)) {
    for (int difference = 0; difference < 256; ++difference) {
      const int lowered = std::min(difference, penalties.whole_edge) * (penalties.most - penalties.least);
      jump_[static_cast<std::size_t>(difference)] =
          static_cast<std::uint8_t>(penalties.most - lowered / std::max(1, penalties.whole_edge));
    }
    for (auto& rows : rows_) {
      for (PathRow& row : rows) {
        row.lanes.assign(static_cast<std::size_t>(sheets.columns) * stride_, kNoPath);
        row.least.assign(static_cast<std::size_t>(sheets.columns), 0);
      }
    }
  }

  // Through all rows: upwards from the first cell, which begins the sums, and downwards from the last.
  void Run(bool is_upwards) {
    const int way = is_upwards ? 1 : -1;
    for (int done = 0; done < sheets_.rows; ++done) {
      const int row = is_upwards ? done : sheets_.rows - 1 - done;
      for (int passed = 0; passed < sheets_.columns; ++passed) {
        Visit(is_upwards ? passed : sheets_.columns - 1 - passed, row, way, done == 0);
      }
      for (auto& rows : rows_) std::swap(rows[0], rows[1]);
    }
  }

 private:
  // The cell before on a path; without lanes there is none.
  struct Before {
    const std::uint8_t* lanes = nullptr;
    Lanes least, jumped;
    std::array<int, 2> to_first{}, to_second{};  // shifts from this cell's sheets to the other's
    bool has_second = false;
  };

  int ShiftOf(float low_m, float other_low_m) const {
    const float steps = std::clamp((low_m - other_low_m) * per_step_, -1000.0f, 1000.0f);
    return static_cast<int>(steps + (steps >= 0.0f ? 0.5f : -0.5f));
  }

  Before CellBefore(std::size_t cell, int path, int column, int row, int way, bool is_first_row) const {
    constexpr std::array<int, kPaths> kBack = {-1, -1, 0, 1};
    const int from_column = column + way * kBack[static_cast<std::size_t>(path)];
    const int from_row = path == 0 ? row : row - way;
    Before before;
    if (from_column < 0 || from_column >= sheets_.columns || (path != 0 && is_first_row)) return before;
    // The path along the row reads what this row has written; the others the row before.
    const PathRow& from = rows_[static_cast<std::size_t>(path)][path == 0 ? 0 : 1];
    const std::size_t other = static_cast<std::size_t>(from_row) * sheets_.columns + from_column;
    before.lanes = from.lanes.data() + static_cast<std::size_t>(from_column) * stride_;
    const std::uint8_t least = from.least[static_cast<std::size_t>(from_column)];
    before.least = cv::v_setall_u8(least);
    before.jumped =
        before.least + cv::v_setall_u8(jump_[static_cast<std::size_t>(std::abs(gray_[cell] - gray_[other]))]);
    before.has_second = sheets_.second[other] != HeightSheets::kNone;
    before.to_first[0] = ShiftOf(sheets_.low_m[cell], sheets_.low_m[other]);
    before.to_first[1] = ShiftOf(sheets_.second_low_m[cell], sheets_.low_m[other]);
    if (before.has_second) {
      before.to_second[0] = ShiftOf(sheets_.low_m[cell], sheets_.second_low_m[other]);
      before.to_second[1] = ShiftOf(sheets_.second_low_m[cell], sheets_.second_low_m[other]);
    }
    return before;
  }

  Lanes Cheaper(Lanes best, const std::uint8_t* lanes, int shift, Lanes step) const {
    if (shift < -kSheetHeights || shift > kSheetHeights) return best;
    lanes += shift;
    return cv::v_min(
        best, cv::v_min(cv::v_load(lanes), cv::v_min(cv::v_load(lanes - 1), cv::v_load(lanes + 1)) + step));
  }

  // kSheetHeights heights of one of the cell's sheets, along all four paths.
  void VisitLanes(const std::array<Before, kPaths>& before, std::size_t sheet, int at,
                  const std::uint8_t* cost, const std::array<std::uint8_t*, kPaths>& out,
                  std::array<Lanes, kPaths>& least, bool begins, std::uint16_t* sum) const {
    const Lanes own = cv::v_load(cost), step = cv::v_setall_u8(step_penalty_);
    cv::v_uint16x8 low = cv::v_setzero_u16(), high = cv::v_setzero_u16();
    if (!begins) {
      low = cv::v_load(sum);
      high = cv::v_load(sum + 8);
    }
    const int to = sheet == 0 ? kPad + at : second_at_;
    for (std::size_t path = 0; path < kPaths; ++path) {
      Lanes here = own;
      if (const Before& from = before[path]; from.lanes != nullptr) {
        Lanes best = Cheaper(from.jumped, from.lanes + kPad + at, from.to_first[sheet], step);
        if (from.has_second) best = Cheaper(best, from.lanes + second_at_, from.to_second[sheet], step);
        here = own + (best - from.least);
      }
      cv::v_store(out[path] + to, here);
      least[path] = cv::v_min(least[path], here);
      cv::v_uint16x8 wide_low, wide_high;
      cv::v_expand(here, wide_low, wide_high);
      low += wide_low;
      high += wide_high;
    }
    cv::v_store(sum, low);
    cv::v_store(sum + 8, high);
  }

  void Visit(int column, int row, int way, bool is_first_row) {
    const std::size_t cell = static_cast<std::size_t>(row) * sheets_.columns + column;
    std::array<Before, kPaths> before;
    std::array<std::uint8_t*, kPaths> out;
    std::array<Lanes, kPaths> least;
    for (std::size_t path = 0; path < kPaths; ++path) {
      before[path] = CellBefore(cell, static_cast<int>(path), column, row, way, is_first_row);
      out[path] = rows_[path][0].lanes.data() + static_cast<std::size_t>(column) * stride_;
      least[path] = cv::v_setall_u8(kNoPath);
    }
    const std::size_t heights = static_cast<std::size_t>(sheets_.heights);
    for (int at = 0; at < sheets_.heights; at += kSheetHeights) {
      const std::size_t from = cell * heights + static_cast<std::size_t>(at);
      VisitLanes(before, 0, at, costs_.first.data() + from, out, least, way > 0, sums_.first.data() + from);
    }
    if (const std::int32_t second = sheets_.second[cell]; second != HeightSheets::kNone) {
      const std::size_t from = static_cast<std::size_t>(second) * kSheetHeights;
      VisitLanes(before, 1, 0, costs_.second.data() + from, out, least, way > 0, sums_.second.data() + from);
    }
    for (std::size_t path = 0; path < kPaths; ++path) {
      rows_[path][0].least[static_cast<std::size_t>(column)] = cv::v_reduce_min(least[path]);
    }
  }

  const HeightSheets& sheets_;
  const SheetCosts& costs_;
  const std::vector<std::uint8_t>& gray_;
  SheetSums& sums_;
  const std::uint8_t step_penalty_;
  const float per_step_;
  const int second_at_, stride_;
  std::array<std::uint8_t, 256> jump_;
  std::array<std::array<PathRow, 2>, kPaths> rows_;  // this row and the one before
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
