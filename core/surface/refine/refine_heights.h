// What is done to a level's heights once they are picked: what is not known is filled from around it, single
// cells are evened out. Row by row; metres. Pure; any thread.
#pragma once

#include <cstdint>
#include <vector>

namespace skyquilt::surface {

// Cells of one level: heights, and which of them were measured.
struct LevelHeights {
  int columns = 0, rows = 0;
  std::vector<float> heights_m;
  std::vector<std::uint8_t> is_known;

  std::size_t IndexOf(int column, int row) const { return static_cast<std::size_t>(row) * columns + column; }
};

// Of a cell that is not known, what those around it say: where five of eight directions meet known ones
// within `reach` cells, the lower of them (what is not seen lies beside a wall, not on it), all those within
// most_step_m of the second lowest, the nearer the more. Else what is expected.
void FillUnknown(LevelHeights& level, const std::vector<float>& expected_m, int reach, float most_step_m);

// The mean of 5 x 5 cells, fewer at the border.
std::vector<std::uint8_t> MeansAround(const std::vector<std::uint8_t>& values, int columns, int rows);

// Each cell becomes the median of its 3 x 3, the border as it is.
void TakeMedians(LevelHeights& level);

}  // namespace skyquilt::surface
