// ReadTileTable: which tiles a finished MBTiles has, and of what size and format each one is, without reading
// them: MbtilesWriter says so beside their places. Those of earlier versions did not, and are read through
// once. Memory: 40 bytes a tile. One thread. Errors: kCorrupt (no tiles, or one that is nowhere), those of
// the database.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/result.h"
#include "core/geo/tile_id.h"
#include "core/image/picture_format.h"
#include "storage/db/sqlite_db.h"

namespace skyquilt::storage {

struct TableTile {
  geo::TileId tile;
  std::int64_t content_id = 0;  // tile_data_id; equal ones are equal bytes
  std::uint32_t bytes = 0;
  image::PictureFormat format = image::PictureFormat::kJpeg;
};

// By their zooms, columns and rows.
Result<std::vector<TableTile>> ReadTileTable(SqliteDb& mbtiles);

}  // namespace skyquilt::storage
