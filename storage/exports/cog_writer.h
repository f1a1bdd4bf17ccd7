// WriteCog: a finished MBTiles as a cloud-optimised GeoTIFF in EPSG:3857, tiled like the web map (GDAL's
// GoogleMapsCompatible). The tiles' own JPEG (or WebP) bytes are copied, overviews from the pyramid's own
// levels; only the partly transparent tiles at the fringe, and those few of the coarsest overviews whose
// corner is no tile's (see tile_grid.h), are encoded anew as JPEG with a one-bit mask. Streams: memory is the
// directories (16 bytes per tile) and a few tiles per thread. Published by rename. Blocking. Errors: kIo,
// kOutOfSpace, kCorrupt, kCancelled.
#pragma once

#include <cstdint>
#include <filesystem>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "storage/exports/tiff_head.h"
#include "storage/exports/tile_grid.h"
#include "storage/tilesets/tile_source.h"

namespace skyquilt::storage {

// Beyond this a classic TIFF's 32-bit places might not reach.
inline constexpr std::uint64_t kClassicTiffLimitBytes = std::uint64_t{3500} << 20;

// What the GeoTIFF of a tileset is like.
int TileSizeOf(const TilesetFacts& metadata);
TiffTiles TiffTilesOf(const TilesetFacts& metadata);
GridAlignment GridAlignmentOf(TiffTiles tiles);

struct CogOptions {
  int jpeg_quality = 85;  // of tiles encoded anew
  int threads = 0;        // 0 = all cores
};

Result<void> WriteCog(const std::filesystem::path& mbtiles, const std::filesystem::path& path,
                      const CogOptions& options, Progress& progress);

}  // namespace skyquilt::storage
