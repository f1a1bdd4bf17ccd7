// SeamGrid: the coarse cells in which the map decides which photo shows what. Cells are squares of the base
// zoom's world-wide pixel grid, so that they do not depend on blocks; columns count on beyond the date line.
// Any thread.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "core/geo/tile_id.h"
#include "core/render/mosaic_plan.h"

namespace skyquilt::render {

struct SeamGrid {
  int zoom = 0;
  int tile_size_px = 256;
  int cell_px = 32;
  std::int64_t first_column = 0, first_row = 0;  // in the world's cells
  int columns = 0, rows = 0;

  double CellInMercM() const;
  // Centre of a cell; column and row count from the grid's north-west and may lie outside it.
  Eigen::Vector2d CellInMerc(int column, int row) const;
  // The cell (counted from the grid's corner) at the north-west of a block.
  Eigen::Vector2i CellOfBlock(const geo::TileId& block_tile, int block_levels) const;
};

// Cells of about 1/128 of a photo (of this longer side) over everything that any photo sees.
SeamGrid MakeSeamGrid(const MosaicPlan& plan, double photo_side_px, double ground_per_merc);

}  // namespace skyquilt::render
