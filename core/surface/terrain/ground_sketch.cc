#include "core/surface/terrain/ground_sketch.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/check.h"
#include "core/surface/terrain/ground_model.h"

namespace skyquilt::surface {
namespace {

constexpr double kMaxSketchCells = 4e6;
// What lies so far above the coarse ground begins to stand on it; twice as far, it does.
constexpr float kOnGroundM = 0.15f;

int StepOf(int columns, int rows, double cell_m) {
  const double cells = static_cast<double>(columns) * rows;
  const double step =
      std::max(std::ceil(kSketchCellM / cell_m), std::ceil(std::sqrt(cells / kMaxSketchCells)));
  return static_cast<int>(std::clamp(step, 1.0, static_cast<double>(std::max(columns, rows))));
}

}  // namespace

GroundSketch::GroundSketch(int columns, int rows, double cell_m)
    : columns_(columns), rows_(rows), cell_m_(cell_m) {
  SKYQUILT_CHECK(columns > 0 && rows > 0 && cell_m > 0.0, "a sketch needs a grid");
  step_ = StepOf(columns, rows, cell_m);
  coarse_columns_ = (columns + step_ - 1) / step_;
  coarse_rows_ = (rows + step_ - 1) / step_;
  heights_m_.assign(static_cast<std::size_t>(coarse_columns_) * coarse_rows_, 0.0f);
  counts_.assign(heights_m_.size(), 0.0f);
}

void GroundSketch::Add(const CellBox& box, const std::vector<float>& heights_m,
                       const std::vector<std::uint8_t>& agreeing_photos) {
  std::size_t cell = 0;
  for (int row = box.row; row < box.row + box.rows; ++row) {
    for (int column = box.column; column < box.column + box.columns; ++column, ++cell) {
      if (std::isnan(heights_m[cell])) continue;
      const std::size_t coarse = CoarseCell(column, row);
      // What was filled counts only where nothing was measured: towards the rim, where the ground goes on.
      const bool is_measured = agreeing_photos[cell] != 0;
      float& count = counts_[coarse];
      if (is_measured ? count <= 0.0f : count > 0.0f) {
        if (!is_measured) continue;
        count = heights_m_[coarse] = 0.0f;
      }
      // A running mean: a sum of heights above the ellipsoid would lose its millimetres.
      count += is_measured ? 1.0f : -1.0f;
      heights_m_[coarse] += (heights_m[cell] - heights_m_[coarse]) / std::abs(count);
    }
  }
}

void GroundSketch::Finish() {
  for (std::size_t i = 0; i < heights_m_.size(); ++i) {
    if (counts_[i] == 0.0f) heights_m_[i] = std::numeric_limits<float>::quiet_NaN();
  }
  counts_ = {};
  heights_m_ = GroundUnder(heights_m_, coarse_columns_, coarse_rows_, cell_m_ * step_).heights_m;
}

GroundModel GroundSketch::GroundOf(const CellBox& box, const std::vector<float>& heights_m,
                                   const std::vector<std::uint8_t>& agreeing_photos) const {
  GroundModel ground{heights_m, std::vector<std::uint8_t>(heights_m.size(), 0)};
  const float scale = 1.0f / static_cast<float>(step_);
  const auto between = [&](int cell, int coarse_cells) {
    const float at = scale * (static_cast<float>(cell) + 0.5f) - 0.5f;
    return std::clamp(at, 0.0f, static_cast<float>(coarse_cells - 1));
  };
  std::size_t cell = 0;
  for (int row = box.row; row < box.row + box.rows; ++row) {
    const float y = between(row, coarse_rows_);
    const int low = static_cast<int>(y), high = std::min(low + 1, coarse_rows_ - 1);
    const float v = y - static_cast<float>(low);
    const float* below = heights_m_.data() + static_cast<std::size_t>(low) * coarse_columns_;
    const float* above = heights_m_.data() + static_cast<std::size_t>(high) * coarse_columns_;
    for (int column = box.column; column < box.column + box.columns; ++column, ++cell) {
      const float shown = heights_m[cell];
      if (std::isnan(shown)) continue;
      const float x = between(column, coarse_columns_);
      const int left = static_cast<int>(x), right = std::min(left + 1, coarse_columns_ - 1);
      const float u = x - static_cast<float>(left);
      const float coarse = (1.0f - v) * ((1.0f - u) * below[left] + u * below[right]) +
                           v * ((1.0f - u) * above[left] + u * above[right]);
      const float stands = agreeing_photos[cell] == 0
                               ? 1.0f
                               : std::clamp((shown - coarse - kOnGroundM) / kOnGroundM, 0.0f, 1.0f);
      ground.heights_m[cell] = shown + stands * (coarse - shown);
      ground.is_ground[cell] = stands == 0.0f ? 1 : 0;
    }
  }
  return ground;
}

}  // namespace skyquilt::surface
