// LayOutPmtiles: a finished MBTiles of MbtilesWriter as a PMTiles archive (version 3) that is nowhere:
// header, directories and the place of every tile, from the table of tiles alone. The same bytes, clustered
// along the Hilbert curve, each once. Memory: 16 bytes a tile and the directories; 100 while it is laid out.
// One thread. Errors: kCorrupt, those of the database. Source: PMTiles specification version 3.
#pragma once

#include <memory>

#include "core/base/result.h"
#include "storage/db/sqlite_db.h"
#include "storage/exports/streamed/streamed_file.h"

namespace skyquilt::storage {

Result<std::shared_ptr<const StreamedFile>> LayOutPmtiles(SqliteDb& mbtiles);

}  // namespace skyquilt::storage
