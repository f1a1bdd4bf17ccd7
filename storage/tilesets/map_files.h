// The two files of a map in its folder (tiles, and the state that remembers what they were made from), under
// the names of a finished map, of a run, and of what a killed run left; and what an earlier run left, open
// for reading. Any thread; one run a folder.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include "core/base/digest.h"
#include "core/base/result.h"
#include "core/geo/tile_id.h"
#include "storage/db/sqlite_db.h"

namespace skyquilt::storage {

struct MapFiles {
  std::filesystem::path tiles, state;
};

MapFiles FinishedMap(const std::filesystem::path& folder);
MapFiles TemporaryMap(const std::filesystem::path& folder);
MapFiles LeftOverMap(const std::filesystem::path& folder);

// SQLite's journal beside a file.
std::string JournalOf(const std::filesystem::path& file);

// With their journals.
void RemoveMap(const MapFiles& files);

// What a killed run left gets out of the way of this one's temporary files. Of several killed runs the last
// one that had got somewhere counts: it took over what the one before had.
void SetMapAside(const std::filesystem::path& folder);

// One earlier run, for one thread. The statements select the tiles of a level in a window of columns and rows
// (from the south), and what is kept of a block.
struct EarlierMap {
  SqliteDb tiles, state;
  Statement select_tiles, select_block;
  std::map<geo::TileId, Digest> digests;
  std::string facts;
};

// `is_finished`: a published map, read as it is; else what a killed run left, rolled back to its last commit,
// and read through: seconds a gigabyte.
// Errors: kIo, kCorrupt (also where tiles and state are of two maps).
Result<std::unique_ptr<EarlierMap>> OpenEarlierMap(const MapFiles& files, bool is_finished);

}  // namespace skyquilt::storage
