// SeamGrid: the coarse cells in which the map decides which photo shows what. Cells are squares of the base
// zoom's world-wide pixel grid, so that they do not depend on blocks; columns count on beyond the date line.
// SeamLabels: what it decided. Values; reading from any thread.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

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

// A rectangle of the grid's cells.
struct CellWindow {
  int column = 0, row = 0;  // of its first cell in the grid
  int columns = 0, rows = 0;

  // Index of a grid cell, row by row; -1 outside.
  int IndexOf(int grid_column, int grid_row) const {
    const int x = grid_column - column, y = grid_row - row;
    return x < 0 || y < 0 || x >= columns || y >= rows ? -1 : y * columns + x;
  }
};

inline constexpr std::int32_t kNoPhoto = -1;

// Which photo shows each cell of a seam grid. Stored by chunks, so that a long thin flight costs no more than
// the ground it covers.
class SeamLabels {
 public:
  static constexpr int kChunk = 64;  // cells a side

  SeamLabels() = default;
  SeamLabels(int columns, int rows);
  SeamLabels(const SeamLabels& other);
  SeamLabels& operator=(const SeamLabels& other);
  SeamLabels(SeamLabels&&) = default;
  SeamLabels& operator=(SeamLabels&&) = default;

  std::int32_t At(int column, int row) const {
    const Chunk* chunk = Find(column, row);
    return chunk == nullptr ? kNoPhoto : (*chunk)[Within(column, row)];
  }
  void Set(int column, int row, std::int32_t photo);  // inside the grid only
  // How many cells from here to the east surely have this one's label: all of an empty chunk's row.
  int AlikeFrom(int column, int row) const {
    return Find(column, row) != nullptr ? 1 : std::min(columns_, (column / kChunk + 1) * kChunk) - column;
  }

  int columns() const { return columns_; }
  int rows() const { return rows_; }

 private:
  using Chunk = std::array<std::int32_t, kChunk * kChunk>;
  static std::size_t Within(int column, int row) {
    return static_cast<std::size_t>(row % kChunk) * kChunk + static_cast<std::size_t>(column % kChunk);
  }
  std::size_t ChunkOf(int column, int row) const {
    return static_cast<std::size_t>(row / kChunk) * chunk_columns_ +
           static_cast<std::size_t>(column / kChunk);
  }
  const Chunk* Find(int column, int row) const {
    if (column < 0 || row < 0 || column >= columns_ || row >= rows_) return nullptr;
    return chunks_[ChunkOf(column, row)].get();
  }

  int columns_ = 0, rows_ = 0;
  std::size_t chunk_columns_ = 0;
  std::vector<std::unique_ptr<Chunk>> chunks_;
};

// What an earlier run decided, for a flight of which these photos came first.
struct KnownLabels {
  SeamGrid grid;
  SeamLabels labels;
  std::size_t photos = 0;

  // Of a cell of the world, as the grid counts them.
  std::int32_t AtWorld(std::int64_t column, std::int64_t row) const {
    return labels.At(static_cast<int>(column - grid.first_column), static_cast<int>(row - grid.first_row));
  }
};

}  // namespace skyquilt::render
