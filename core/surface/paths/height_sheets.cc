#include "core/surface/paths/height_sheets.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/check.h"

namespace skyquilt::surface {
namespace {

// A step of the ground may lie so many coarse cells from where the coarser level has it.
constexpr int kEdgeReach = 2;
// Steps about the smoothed heights that one sheet is trusted to hold, out of half its heights.
constexpr float kOneSheetSteps = 6.0f;
// Of two sheets each has so many steps beyond its side of the step, and the others towards the other side.
constexpr float kStepsBeyond = 6.0f;
// Neighbours further apart than this are two sides of a step: nothing lies between them.
constexpr float kSmoothSteps = 4.0f;

struct CoarseCell {
  float height_m = 0.0f;
  float lower_m = 0.0f, higher_m = 0.0f;  // the same where there is no step
  float sure_m = 0.0f;  // the highest about it, where a higher one was doubted; else infinite
  bool has_step = false;
};

// The least or greatest of a square about each cell, rows and columns apart.
template <typename Choose>
std::vector<float> OfSquares(const std::vector<float>& values, int columns, int rows, const Choose& choose) {
  std::vector<float> along(values.size()), result(values.size());
  for (int row = 0; row < rows; ++row) {
    const float* from = values.data() + static_cast<std::size_t>(row) * columns;
    for (int column = 0; column < columns; ++column) {
      float chosen = from[column];
      const int last = std::min(columns - 1, column + kEdgeReach);
      for (int at = std::max(0, column - kEdgeReach); at <= last; ++at) chosen = choose(chosen, from[at]);
      along[static_cast<std::size_t>(row) * columns + column] = chosen;
    }
  }
  for (int row = 0; row < rows; ++row) {
    float* to = result.data() + static_cast<std::size_t>(row) * columns;
    std::copy_n(along.data() + static_cast<std::size_t>(row) * columns, columns, to);
    const int last = std::min(rows - 1, row + kEdgeReach);
    for (int at = std::max(0, row - kEdgeReach); at <= last; ++at) {
      const float* from = along.data() + static_cast<std::size_t>(at) * columns;
      for (int column = 0; column < columns; ++column) to[column] = choose(to[column], from[column]);
    }
  }
  return result;
}

float MeanAround(const std::vector<float>& values, int columns, int rows, int column, int row) {
  float sum = 0.0f;
  int count = 0;
  for (int y = std::max(0, row - 1); y <= std::min(rows - 1, row + 1); ++y) {
    for (int x = std::max(0, column - 1); x <= std::min(columns - 1, column + 1); ++x, ++count) {
      sum += values[static_cast<std::size_t>(y) * columns + x];
    }
  }
  return sum / static_cast<float>(count);
}

std::vector<CoarseCell> CoarseCells(const std::vector<float>& heights, const std::vector<float>& highest,
                                    const CellBox& box, float step_m) {
  const auto lower =
      OfSquares(heights, box.columns, box.rows, [](float a, float b) { return std::min(a, b); });
  const auto sure =
      OfSquares(heights, box.columns, box.rows, [](float a, float b) { return std::max(a, b); });
  const auto higher =
      OfSquares(highest, box.columns, box.rows, [](float a, float b) { return std::max(a, b); });
  std::vector<CoarseCell> cells(heights.size());
  for (int row = 0; row < box.rows; ++row) {
    for (int column = 0; column < box.columns; ++column) {
      const std::size_t i = static_cast<std::size_t>(row) * box.columns + column;
      CoarseCell& cell = cells[i];
      cell.height_m = heights[i];
      cell.sure_m = higher[i] > sure[i] ? sure[i] : std::numeric_limits<float>::infinity();
      const float mean_m = MeanAround(heights, box.columns, box.rows, column, row);
      cell.has_step = std::max(higher[i] - mean_m, mean_m - lower[i]) > kOneSheetSteps * step_m;
      cell.lower_m = cell.has_step ? lower[i] : mean_m;
      cell.higher_m = cell.has_step ? higher[i] : mean_m;
    }
  }
  return cells;
}

// Between four cells where they lie on one smooth surface, else of the nearest.
inline float Between(const std::array<float, 4>& corners, float u, float v, float smooth_m) {
  const float least = std::min(std::min(corners[0], corners[1]), std::min(corners[2], corners[3])),
              greatest = std::max(std::max(corners[0], corners[1]), std::max(corners[2], corners[3]));
  if (greatest - least > smooth_m) return corners[(u > 0.5f ? 1 : 0) + (v > 0.5f ? 2 : 0)];
  return (1.0f - v) * ((1.0f - u) * corners[0] + u * corners[1]) +
         v * ((1.0f - u) * corners[2] + u * corners[3]);
}

}  // namespace

HeightSheets SheetsAbout(int columns, int rows, std::vector<float> ground_m, double low_m, double step_m,
                         int heights) {
  SKYQUILT_CHECK(heights > 0 && heights % kSheetHeights == 0, "sheets hold whole vectors of heights");
  HeightSheets sheets;
  sheets.columns = columns;
  sheets.rows = rows;
  sheets.compared.assign(static_cast<std::size_t>(rows), {0, columns});
  sheets.heights = heights;
  sheets.step_m = static_cast<float>(step_m);
  sheets.expected_at = static_cast<int>(std::lround(low_m / step_m));
  sheets.low_m = ground_m;
  for (float& z_m : sheets.low_m) z_m -= static_cast<float>(low_m);
  sheets.second.assign(ground_m.size(), HeightSheets::kNone);
  sheets.second_low_m = sheets.low_m;
  sheets.expected_m = std::move(ground_m);
  return sheets;
}

HeightSheets SheetsFollowing(const std::vector<float>& coarse_m, const std::vector<float>& highest_m,
                             const CellBox& coarse, const CellBox& fine, double step_m) {
  const float step = static_cast<float>(step_m);
  const std::vector<CoarseCell> cells = CoarseCells(coarse_m, highest_m, coarse, step);
  HeightSheets sheets;
  sheets.columns = fine.columns;
  sheets.rows = fine.rows;
  sheets.compared.assign(static_cast<std::size_t>(fine.rows), {0, fine.columns});
  sheets.step_m = step;
  const std::size_t count = fine.Count();
  sheets.low_m.resize(count);
  sheets.second.assign(count, HeightSheets::kNone);
  sheets.second_low_m.resize(count);
  sheets.expected_m.resize(count);
  sheets.doubted_above_m.resize(count);
  std::size_t i = 0;
  for (int row = 0; row < fine.rows; ++row) {
    // A coarse cell's centre lies between those of its two by two finer ones.
    const float y = std::clamp(0.5f * (static_cast<float>(fine.row + row - 2 * coarse.row) - 0.5f), 0.0f,
                               static_cast<float>(coarse.rows) - 1.001f);
    const int below = static_cast<int>(y);
    const float v = y - static_cast<float>(below);
    for (int column = 0; column < fine.columns; ++column, ++i) {
      const float x = std::clamp(0.5f * (static_cast<float>(fine.column + column - 2 * coarse.column) - 0.5f),
                                 0.0f, static_cast<float>(coarse.columns) - 1.001f);
      const int left = static_cast<int>(x);
      const float u = x - static_cast<float>(left);
      const CoarseCell* corner = cells.data() + static_cast<std::size_t>(below) * coarse.columns + left;
      const CoarseCell* above = corner + coarse.columns;
      const CoarseCell& nearest = (v > 0.5f ? above : corner)[u > 0.5f ? 1 : 0];
      const auto of = [&](float CoarseCell::*height) {
        return Between({corner->*height, corner[1].*height, above->*height, above[1].*height}, u, v,
                       kSmoothSteps * step);
      };
      const float lower = of(&CoarseCell::lower_m);
      sheets.expected_m[i] = of(&CoarseCell::height_m);
      sheets.low_m[i] = lower - step * (nearest.has_step ? kStepsBeyond : 0.5f * kSheetHeights);
      sheets.second_low_m[i] = sheets.low_m[i];
      sheets.doubted_above_m[i] = nearest.sure_m + kStepsBeyond * step;
      if (!nearest.has_step) continue;
      sheets.second[i] = sheets.second_count++;
      const float above_first = sheets.low_m[i] + step * kSheetHeights;
      const float about_higher = of(&CoarseCell::higher_m) - step * (kSheetHeights - 1 - kStepsBeyond);
      sheets.second_low_m[i] = std::max(above_first, about_higher);
    }
  }
  return sheets;
}

}  // namespace skyquilt::surface
