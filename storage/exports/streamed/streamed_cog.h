// LayOutCog: a finished MBTiles of MbtilesWriter as the GeoTIFF of cog_writer.h, laid out over the tiles from
// their table alone. Tiles that are JPEG (or WebP) already are copied when they are read. How many bytes the
// others take as JPEG is not known before they are encoded, and their places in the file must not depend on
// it: each has room by the size of its stored tile, which its JPEG is filled up to; where that is not enough
// for the quality asked for (some two of a hundred at a map's edge), that tile's is lowered until it is.
// Memory: 16 bytes a tile, 24 a cell of the directories. One thread. Errors: kCorrupt, those of the database.
#pragma once

#include <memory>

#include "core/base/result.h"
#include "storage/db/sqlite_db.h"
#include "storage/exports/streamed/streamed_file.h"

namespace skyquilt::storage {

inline constexpr int kStreamedCogQuality = 85;  // of tiles encoded anew

Result<std::shared_ptr<const StreamedFile>> LayOutCog(SqliteDb& mbtiles, const TilesetFacts& metadata);

}  // namespace skyquilt::storage
