// SeamLevels: what is added to each photo near its seams so that brightness and colour pass smoothly from one
// photo to the next: the low band of a two-band blend, kept on the seam grid. At a seam both sides come to
// the same mean; away from it the photo is left alone. Differences of content (a leaning roof, a car) are not
// light and are left out. Source: the two-band split of Brown and Lowe, Automatic panoramic image stitching
// (2007), with the low band as a correction field. Deterministic; any number of threads.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/render/seams/low_res_view.h"
#include "core/render/seams/seam_labels.h"

namespace skyquilt::render {

// A photo's correction, cell by cell of its view.
struct PhotoLevels {
  int column = 0, row = 0, columns = 0, rows = 0;
  std::vector<bool> sees_whole;                      // the photo's edge is not near the cell
  std::vector<std::array<std::int16_t, 3>> eighths;  // of a grey level; empty: no correction

  bool SeesWhole(int grid_column, int grid_row) const {
    const int x = grid_column - column, y = grid_row - row;
    return x >= 0 && y >= 0 && x < columns && y < rows &&
           sees_whole[static_cast<std::size_t>(y) * columns + x];
  }

  // Grey levels to add; 0 outside.
  std::array<float, 3> At(int grid_column, int grid_row) const {
    const int x = grid_column - column, y = grid_row - row;
    if (x < 0 || y < 0 || x >= columns || y >= rows || eighths.empty()) return {};
    const auto& cell = eighths[static_cast<std::size_t>(y) * columns + x];
    return {0.125f * cell[0], 0.125f * cell[1], 0.125f * cell[2]};
  }
};

// Without evens_light the corrections stay empty. `wanted`, by photo: the others get none; of those that
// share cells with the wanted ones the views must be there.
std::vector<PhotoLevels> LevelSeams(const std::vector<LowResView>& views, const SeamLabels& labels,
                                    bool evens_light, int threads, const std::vector<char>* wanted = nullptr);

}  // namespace skyquilt::render
