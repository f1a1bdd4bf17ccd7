#include "storage/exports/stored_tiles.h"

#include <algorithm>
#include <limits>
#include <string>

#include "core/base/try.h"

namespace skyquilt::storage {
namespace {

// Of a row that begins with zoom, column and row, which is counted from the south.
Result<geo::TileId> TileOfRow(const Statement& row) {
  const std::int64_t zoom = row.ColumnInt64(0);
  const auto side = std::int64_t{1} << std::clamp<std::int64_t>(zoom, 0, geo::kMaxZoom);
  return geo::TileId::Make(zoom, row.ColumnInt64(1), side - 1 - row.ColumnInt64(2));
}

}  // namespace

Result<TileWalk> TileWalk::Of(SqliteDb& db) {
  SKYQUILT_TRY_ASSIGN(
      auto rows,
      db.Prepare(
          "SELECT zoom_level, tile_column, tile_row, tile_data FROM tiles ORDER BY zoom_level, tile_column, "
          "tile_row"));
  return TileWalk(std::move(rows));
}

Result<bool> TileWalk::Next() {
  Result<bool> more = rows_.Step();
  if (!more || !*more) return more;
  SKYQUILT_TRY_ASSIGN(tile_, TileOfRow(rows_));
  return true;
}

std::string_view TileWalk::bytes() const {
  const auto blob = rows_.ColumnBlob(3);
  return {reinterpret_cast<const char*>(blob.data()), blob.size()};
}

Result<std::int64_t> CountTiles(SqliteDb& db) { return db.Number("SELECT count(*) FROM tiles"); }

namespace {

constexpr const char* kStatedSizes =
    "SELECT count(*) FROM pragma_table_info('tiles_shallow') WHERE name IN ('tile_bytes', 'tile_format')";
constexpr const char* kStated =
    "SELECT zoom_level, tile_column, tile_row, tile_data_id, tile_bytes, tile_format FROM tiles_shallow";
// The first byte tells JPEG (FF), PNG (89) and WebP (52) apart.
constexpr const char* kMeasured =
    "SELECT s.zoom_level, s.tile_column, s.tile_row, s.tile_data_id, length(d.tile_data), "
    "CASE hex(substr(d.tile_data, 1, 1)) WHEN 'FF' THEN 0 WHEN '52' THEN 1 ELSE 2 END "
    "FROM tiles_shallow s JOIN tiles_data d ON s.tile_data_id = d.tile_data_id";

// Where the tiles' places stand: apart from their bytes, if the tileset has that.
Result<std::string> TableOfPlaces(SqliteDb& mbtiles) {
  SKYQUILT_TRY_ASSIGN(const bool are_apart,
                      mbtiles.Finds("SELECT 1 FROM sqlite_master WHERE name = 'tiles_shallow'"));
  return std::string(are_apart ? "tiles_shallow" : "tiles");
}

}  // namespace

Result<std::vector<TableTile>> ReadTileTable(SqliteDb& mbtiles) {
  SKYQUILT_TRY_ASSIGN(const std::string table, TableOfPlaces(mbtiles));
  if (table == "tiles")
    return Error{ErrorCode::kUnsupportedFormat,
                 "The MBTiles is of another program, whose tiles cannot be laid out anew. Bring it to a "
                 "server with \"skyquilt import\", or take it as MBTiles or KMZ.",
                 ""};
  SKYQUILT_TRY_ASSIGN(const std::int64_t stated, mbtiles.Number(kStatedSizes));
  SKYQUILT_TRY_ASSIGN(auto rows, mbtiles.Prepare(stated == 2 ? kStated : kMeasured));
  const Error damaged{ErrorCode::kCorrupt, "The tileset of the map is damaged. Stitch the flight again.", ""};
  std::vector<TableTile> tiles;
  while (true) {
    SKYQUILT_TRY_ASSIGN(const bool more, rows.Step());
    if (!more) break;
    SKYQUILT_TRY_ASSIGN(const geo::TileId tile, TileOfRow(rows));
    const std::int64_t bytes = rows.ColumnInt64(4);
    const auto format = image::PictureFormatOfMbtiles(rows.ColumnInt64(5));
    if (!format || bytes <= 0 || bytes > std::numeric_limits<std::int32_t>::max()) return damaged;
    tiles.push_back({tile, rows.ColumnInt64(3), static_cast<std::uint32_t>(bytes), *format});
  }
  if (tiles.empty())
    return Error{ErrorCode::kCorrupt, "The tileset of the map holds no tiles. Stitch the flight again.", ""};
  std::sort(tiles.begin(), tiles.end(),
            [](const TableTile& a, const TableTile& b) { return a.tile < b.tile; });
  return tiles;
}

namespace {

struct Extent {
  std::int64_t first_column = 0, last_column = 0, first_row = 0, last_row = 0;
};

// `turn` moves the place where columns begin to count, so that a map across the date line stays in one piece.
Result<Extent> ExtentOf(SqliteDb& mbtiles, const std::string& table, int zoom, std::int64_t turn) {
  const std::int64_t side = std::int64_t{1} << zoom;
  SKYQUILT_TRY_ASSIGN(
      auto query,
      mbtiles.Query(
          "SELECT min((tile_column + ?2) % ?3), max((tile_column + ?2) % ?3), min(tile_row), max(tile_row) "
          "FROM " +
              table + " WHERE zoom_level = ?1",
          zoom, turn, side));
  SKYQUILT_TRY(query.Step());
  return Extent{query.ColumnInt64(0) + turn, query.ColumnInt64(1) + turn, side - 1 - query.ColumnInt64(3),
                side - 1 - query.ColumnInt64(2)};
}

// How many levels above the finest may share its corner for the price of an eighth of the map.
int AlignedLevels(const Extent& extent, int levels) {
  const std::int64_t tiles =
      std::min(extent.last_column - extent.first_column, extent.last_row - extent.first_row) + 1;
  int aligned = 0;
  while (aligned < levels && (std::int64_t{16} << aligned) <= tiles) ++aligned;
  // Tiles have at least 2^8 pixels: so many levels beyond, the corner still lies between whole pixels.
  return std::max(aligned, levels - 8);
}

std::int64_t RoundUp(std::int64_t value, std::int64_t step) { return (value + step - 1) / step * step; }

}  // namespace

std::optional<geo::TileId> GridLevel::TileOf(std::int64_t cell, int east, int south) const {
  const std::int64_t side = std::int64_t{1} << zoom;
  const std::int64_t row = first_row + cell / columns + south;
  if (row >= side) return std::nullopt;
  return *geo::TileId::Make(zoom, (first_column + cell % columns + east) % side, row);
}

Result<void> CheckCells(const GridLevel& level) {
  if (level.CellCount() <= kMaxGridCells) return {};
  return Error{
      ErrorCode::kTooLarge,
      "The map's tiles lie too far apart for one picture of all between them. Cut it into several maps, "
      "or take it as MBTiles, PMTiles or KMZ.",
      ""};
}

Result<std::vector<GridLevel>> GridOf(SqliteDb& mbtiles, int tile_size_px, GridAlignment alignment) {
  int finest = 0, coarsest = 0;
  SKYQUILT_TRY_ASSIGN(const std::string table, TableOfPlaces(mbtiles));
  {
    SKYQUILT_TRY_ASSIGN(auto zooms, mbtiles.Prepare("SELECT max(zoom_level), min(zoom_level) FROM " + table));
    SKYQUILT_TRY(zooms.Step());
    if (zooms.IsNull(0))
      return Error{ErrorCode::kCorrupt, "The tileset of the map holds no tiles. Stitch the flight again.",
                   ""};
    finest = static_cast<int>(zooms.ColumnInt64(0));
    coarsest = static_cast<int>(zooms.ColumnInt64(1));
  }
  const std::int64_t half = finest > 0 ? std::int64_t{1} << (finest - 1) : 0;
  SKYQUILT_TRY_ASSIGN(Extent extent, ExtentOf(mbtiles, table, finest, 0));
  if (finest >= 2 && extent.last_column - extent.first_column >= half) {
    SKYQUILT_TRY_ASSIGN(const Extent turned, ExtentOf(mbtiles, table, finest, half));
    if (turned.last_column - turned.first_column < half) extent = turned;
  }

  int levels = 0;
  while (finest - levels > coarsest) {
    const bool is_small = (extent.last_column >> levels) - (extent.first_column >> levels) < 3 &&
                          (extent.last_row >> levels) - (extent.first_row >> levels) < 3;
    if (is_small) break;
    ++levels;
  }
  const int aligned = alignment == GridAlignment::kAllLevels ? levels : AlignedLevels(extent, levels);
  const std::int64_t first_column = extent.first_column >> aligned << aligned;
  const std::int64_t first_row = extent.first_row >> aligned << aligned;
  // Whole pixels at every level: the width is a multiple of the coarsest level's pixel.
  const std::int64_t coarsest_pixel_px = std::int64_t{1} << levels;
  const std::int64_t width_px =
      RoundUp((extent.last_column + 1 - first_column) * tile_size_px, coarsest_pixel_px);
  const std::int64_t height_px = RoundUp((extent.last_row + 1 - first_row) * tile_size_px, coarsest_pixel_px);
  std::vector<GridLevel> grid;
  for (int level = 0; level <= levels; ++level) {
    const std::int64_t left_px = first_column * tile_size_px >> level;
    const std::int64_t top_px = first_row * tile_size_px >> level;
    GridLevel made;
    made.zoom = finest - level;
    made.first_column = left_px / tile_size_px;
    made.first_row = top_px / tile_size_px;
    made.shift_x_px = static_cast<int>(left_px % tile_size_px);
    made.shift_y_px = static_cast<int>(top_px % tile_size_px);
    made.width_px = width_px >> level;
    made.height_px = height_px >> level;
    made.columns = (made.width_px + tile_size_px - 1) / tile_size_px;
    made.rows = (made.height_px + tile_size_px - 1) / tile_size_px;
    grid.push_back(made);
  }
  return grid;
}

}  // namespace skyquilt::storage
