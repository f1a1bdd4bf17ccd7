// TileGrid: the rectangle of tiles of each zoom that a tileset fills, as the raster formats want it: the
// finest level's north-west corner lies on a tile corner of every coarser level, so that each level's tiles
// are the web map's own. Columns count on beyond the date line for a map that crosses it. A value; any
// thread.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/result.h"
#include "core/geo/tile_id.h"
#include "storage/sqlite_db.h"

namespace skyquilt::storage {

struct GridLevel {
  int zoom = 0;
  std::int64_t first_column = 0;
  std::int64_t first_row = 0;  // from the north
  std::int64_t columns = 0;
  std::int64_t rows = 0;
  std::int64_t width_px =
      0;  // exactly the finest level's over a power of two; the last tiles may reach beyond
  std::int64_t height_px = 0;

  std::int64_t CellCount() const { return columns * rows; }
  // The tile of a cell, counted row by row from the north-west.
  geo::TileId TileOf(std::int64_t cell) const;
};

// The finest zoom first, coarser ones until the whole map is at most three tiles wide and high, which keeps
// the room added for it below the map's size. Errors: kCorrupt without any tile, those of the database.
Result<std::vector<GridLevel>> GridOf(SqliteDb& mbtiles, int tile_size_px);

}  // namespace skyquilt::storage
