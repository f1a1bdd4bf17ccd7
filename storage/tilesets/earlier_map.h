// EarlierMap: what an earlier run left of a map, open for reading. One thread.
#pragma once

#include <map>
#include <memory>
#include <string>

#include "core/base/digest.h"
#include "core/base/result.h"
#include "core/geo/tile_id.h"
#include "storage/db/sqlite_db.h"
#include "storage/tilesets/map_files.h"

namespace skyquilt::storage {

// One earlier run. The statements select the tiles of a level in a window of columns and rows (from the
// south), and what is kept of a block.
struct EarlierMap {
  SqliteDb tiles, state;
  Statement select_tiles, select_block;
  std::map<geo::TileId, Digest> digests;
  std::string facts;
};

// `is_finished`: a published map, read as it is; else what a killed run left, rolled back to its last commit.
// Errors: kIo, kCorrupt (also where tiles and state are of two maps).
Result<std::unique_ptr<EarlierMap>> OpenEarlierMap(const MapFiles& files, bool is_finished);

}  // namespace skyquilt::storage
