// A finished MBTiles of MbtilesWriter as a PMTiles archive (version 3): the same bytes, clustered along the
// Hilbert curve, each once. A browser reads single tiles from it on any file server with range requests. One
// thread. Errors: kCorrupt, those of the database; of the file also kIo, kOutOfSpace, kCancelled. Source:
// PMTiles specification version 3.
#pragma once

#include <filesystem>
#include <memory>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "storage/db/sqlite_db.h"
#include "storage/exports/streamed/streamed_file.h"
#include "storage/tilesets/tile_source.h"

namespace skyquilt::storage {

// As a file that is nowhere: header, directories and the place of every tile, from the table of tiles alone.
// Memory: 16 bytes a tile and the directories; 100 while it is laid out.
Result<std::shared_ptr<const StreamedFile>> LayOutPmtiles(SqliteDb& mbtiles, const TilesetFacts& metadata);

// Written through, a tile at a time, and published by rename. Blocking.
Result<void> WritePmtiles(const std::filesystem::path& mbtiles, const std::filesystem::path& path,
                          Progress& progress);

}  // namespace skyquilt::storage
