// A finished MBTiles as a cloud-optimised GeoTIFF in EPSG:3857, tiled like the web map (GDAL's
// GoogleMapsCompatible). The tiles' own JPEG (or WebP) bytes are copied, overviews from the pyramid's own
// levels; only the partly transparent tiles at the fringe, and those few of the coarsest overviews whose
// corner is no tile's (see stored_tiles.h), are encoded anew as JPEG with a one-bit mask. Errors: kCorrupt,
// kTooLarge (more than kMaxGridCells), those of the database; of the file also kIo, kOutOfSpace, kCancelled.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "storage/db/sqlite_db.h"
#include "storage/exports/stored_tiles.h"
#include "storage/exports/streamed/streamed_file.h"
#include "storage/exports/tiff_head.h"
#include "storage/tilesets/tile_source.h"

namespace skyquilt::storage {

// What the GeoTIFF of a tileset is like.
struct CogLayout {
  int tile_size_px = 256;
  TiffTiles tiles = TiffTiles::kJpeg;
  std::vector<GridLevel> grid;
};
Result<CogLayout> CogLayoutOf(SqliteDb& mbtiles, const TilesetFacts& metadata);
// What the file of these tiles takes at most. A picture that several tiles show counts for each of them.
std::uint64_t MostCogBytes(const CogLayout& layout, const std::vector<TableTile>& table);

struct CogOptions {
  int jpeg_quality = 85;  // of tiles encoded anew
  int threads = 0;        // 0 = all cores
};

// Streams: memory is the directories (16 bytes per tile; 40 before it begins) and a few tiles per thread.
// Published by rename. Blocking.
Result<void> WriteCog(const std::filesystem::path& mbtiles, const std::filesystem::path& path,
                      const CogOptions& options, Progress& progress);

// As a file that is nowhere, laid out over the tiles of MbtilesWriter from their table alone. Tiles that are
// JPEG (or WebP) already are copied when they are read. How many bytes the others take as JPEG is not known
// before they are encoded, and their places in the file must not depend on it: each has room by the size of
// its stored tile, which its JPEG is filled up to; where that is not enough for the quality asked for (some
// two of a hundred at a map's edge), that tile's is lowered until it is. Memory: 16 bytes a tile, 24 a cell
// of the directories. One thread.
Result<std::shared_ptr<const StreamedFile>> LayOutCog(SqliteDb& mbtiles, const TilesetFacts& metadata);

}  // namespace skyquilt::storage
