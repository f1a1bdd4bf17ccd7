#include "storage/exports/streamed/tile_table.h"

#include <algorithm>
#include <limits>

#include "core/base/try.h"
#include "core/image/picture_format.h"

namespace skyquilt::storage {
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

}  // namespace

Result<std::vector<TableTile>> ReadTileTable(SqliteDb& mbtiles) {
  SKYQUILT_TRY_ASSIGN(const std::int64_t stated, mbtiles.Number(kStatedSizes));
  SKYQUILT_TRY_ASSIGN(auto rows, mbtiles.Prepare(stated == 2 ? kStated : kMeasured));
  const Error damaged{ErrorCode::kCorrupt, "The tileset of the map is damaged. Stitch the flight again.", ""};
  std::vector<TableTile> tiles;
  while (true) {
    SKYQUILT_TRY_ASSIGN(const bool more, rows.Step());
    if (!more) break;
    const std::int64_t zoom = rows.ColumnInt64(0);
    const auto side = std::int64_t{1} << std::clamp<std::int64_t>(zoom, 0, geo::kMaxZoom);
    SKYQUILT_TRY_ASSIGN(const auto tile,
                        geo::TileId::Make(zoom, rows.ColumnInt64(1), side - 1 - rows.ColumnInt64(2)));
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

}  // namespace skyquilt::storage
