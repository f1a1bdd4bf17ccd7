#include "storage/exports/tile_walk.h"

#include <algorithm>

#include "core/base/try.h"

namespace skyquilt::storage {

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
  const std::int64_t zoom = rows_.ColumnInt64(0);
  const auto side = std::int64_t{1} << std::clamp<std::int64_t>(zoom, 0, geo::kMaxZoom);
  SKYQUILT_TRY_ASSIGN(tile_, geo::TileId::Make(zoom, rows_.ColumnInt64(1), side - 1 - rows_.ColumnInt64(2)));
  return true;
}

std::string_view TileWalk::bytes() const {
  const auto blob = rows_.ColumnBlob(3);
  return {reinterpret_cast<const char*>(blob.data()), blob.size()};
}

Result<std::int64_t> CountTiles(SqliteDb& db) { return db.Number("SELECT count(*) FROM tiles"); }

}  // namespace skyquilt::storage
