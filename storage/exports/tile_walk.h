// TileWalk: all tiles of a finished MBTiles in one pass, the coarsest first. Memory: one tile. One thread;
// must not outlive its database. Errors: kCorrupt (a tile that is nowhere), those of the database.
#pragma once

#include <cstdint>
#include <string_view>

#include "core/base/result.h"
#include "core/geo/tile_id.h"
#include "storage/db/sqlite_db.h"

namespace skyquilt::storage {

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

}  // namespace skyquilt::storage
