// HeightSheets: the heights that are tried at each cell of a level. One sheet of heights evenly spaced where
// the ground is roughly known; where the coarser level shows a step (a roof beside the ground) two sheets of
// kSheetHeights, one about the lower and one about the higher side, so that a wall of any height costs no
// more than a low one and either side may win up to the edge. Metres of enu. Values; any thread.
#pragma once

#include <cstdint>
#include <vector>

#include "core/surface/dense_surface.h"

namespace skyquilt::surface {

inline constexpr int kSheetHeights = 16;

// Columns from the first to before the end.
struct ColumnSpan {
  int first = 0, end = 0;
};

struct HeightSheets {
  int columns = 0, rows = 0;
  int heights =
      kSheetHeights;  // of the first sheet, a multiple of kSheetHeights; that if there are second ones
  float step_m = 1.0f;
  int expected_at = kSheetHeights / 2;  // which height of a first sheet is about the expected one
  std::vector<float> low_m;             // by cell: the lowest of its first sheet
  // By cell: the number of its second sheet, or kNone; and that sheet's lowest (the first one's where there
  // is no second).
  static constexpr std::int32_t kNone = -1;
  std::vector<std::int32_t> second;
  std::vector<float> second_low_m;
  std::int32_t second_count = 0;
  std::vector<float> expected_m;  // what the coarser level says
  // By cell: what lies higher was doubted by the coarser level; infinite where nothing was. Empty: nowhere.
  std::vector<float> doubted_above_m;
  // By row: the columns that are compared, of which all that two photos see are. Nothing is tried at others.
  std::vector<ColumnSpan> compared;

  std::size_t Cells() const { return low_m.size(); }
};

// All heights between, at each cell alike: from low_m below the ground, `heights` of them.
HeightSheets SheetsAbout(int columns, int rows, std::vector<float> ground_m, double low_m, double step_m,
                         int heights);

// About the heights of a level whose cells are twice as large, and what may stand there (`highest_m`, nowhere
// lower); both boxes count cells of their own level from the same corner, and the coarser one reaches beyond
// the finer.
HeightSheets SheetsFollowing(const std::vector<float>& coarse_m, const std::vector<float>& highest_m,
                             const CellBox& coarse, const CellBox& fine, double step_m);

}  // namespace skyquilt::surface
