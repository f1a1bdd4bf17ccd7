// TileGrid: the rectangle of cells of each zoom that a tileset fills, as the raster formats want it: all
// levels have the same north-west corner. It lies on a tile corner of the finest level and of as many coarser
// ones as the room added for it allows; their cells are the web map's own tiles. At the levels beyond, cells
// begin inside tiles. Columns count on beyond the date line for a map that crosses it. A value; any thread.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/base/result.h"
#include "core/geo/tile_id.h"
#include "storage/db/sqlite_db.h"

namespace skyquilt::storage {

struct GridLevel {
  int zoom = 0;
  std::int64_t first_column = 0;
  std::int64_t first_row = 0;  // from the north
  int shift_x_px = 0;          // the first cell begins here in its tile
  int shift_y_px = 0;
  std::int64_t columns = 0;
  std::int64_t rows = 0;
  std::int64_t width_px =
      0;  // exactly the finest level's over a power of two; the last tiles may reach beyond
  std::int64_t height_px = 0;

  std::int64_t CellCount() const { return columns * rows; }
  // Cells are tiles.
  bool IsAligned() const { return shift_x_px == 0 && shift_y_px == 0; }
  // The tile that a cell begins in, the cells counted row by row from the north-west, or one so many tiles
  // farther east and south. Absent beyond the world's southern edge.
  std::optional<geo::TileId> TileOf(std::int64_t cell, int east = 0, int south = 0) const;
};

enum class GridAlignment {
  kAllLevels,   // every cell is a tile; the room added stays below the map's size
  kFineLevels,  // the room added stays below an eighth of the map's width and height, where that is possible
};

// The finest zoom first, coarser ones until the whole map is at most three tiles wide and high. Errors:
// kCorrupt without any tile, those of the database.
Result<std::vector<GridLevel>> GridOf(SqliteDb& mbtiles, int tile_size_px, GridAlignment alignment);

}  // namespace skyquilt::storage
