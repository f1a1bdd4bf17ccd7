// What tiles a finished MBTiles holds, as other formats ask: all of them in one pass (TileWalk), their sizes
// and formats without their bytes (ReadTileTable), the rectangle of cells that they fill (GridOf). One thread
// a database. Errors: kCorrupt (no tiles, or one that is nowhere), those of the database.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/geo/tile_id.h"
#include "core/image/picture_format.h"
#include "storage/db/sqlite_db.h"

namespace skyquilt::storage {

// The coarsest tiles first. Memory: one tile. Must not outlive its database.
class TileWalk {
 public:
  static Result<TileWalk> Of(SqliteDb& db);
  // False: no more.
  Result<bool> Next();
  const geo::TileId& tile() const { return tile_; }
  // Until the next Next().
  std::string_view bytes() const;

 private:
  explicit TileWalk(Statement rows) : rows_(std::move(rows)) {}
  Statement rows_;
  geo::TileId tile_;
};

Result<std::int64_t> CountTiles(SqliteDb& db);

struct TableTile {
  geo::TileId tile;
  std::int64_t content_id = 0;  // tile_data_id; equal ones are equal bytes
  std::uint32_t bytes = 0;
  image::PictureFormat format = image::PictureFormat::kJpeg;
};

// By their zooms, columns and rows. MbtilesWriter says beside the tiles' places what they are; tilesets of
// earlier versions did not, and are read through once; those of other programs are kUnsupportedFormat.
// Memory: 40 bytes a tile.
Result<std::vector<TableTile>> ReadTileTable(SqliteDb& mbtiles);

// The cells of one zoom, as the raster formats want them: all levels have the same north-west corner. It lies
// on a tile corner of the finest level and of as many coarser ones as the room added for it allows; their
// cells are the web map's own tiles. At the levels beyond, cells begin inside tiles. Columns count on beyond
// the date line for a map that crosses it. A value.
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

// Between tiles that lie apart are cells too, and whoever lays out a picture of a level has a place for each.
inline constexpr std::int64_t kMaxGridCells = std::int64_t{1} << 27;
// Errors: kTooLarge (more of them).
Result<void> CheckCells(const GridLevel& level);

// The finest zoom first, coarser ones until the whole map is at most three tiles wide and high.
Result<std::vector<GridLevel>> GridOf(SqliteDb& mbtiles, int tile_size_px, GridAlignment alignment);

}  // namespace skyquilt::storage
