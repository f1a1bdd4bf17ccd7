// WriteThumbnail: the whole map as one small PNG, transparent where it is empty, from the overviews of a
// GeoTIFF. WriteTilesThumbnail: from the tiles of an MBTiles, as far as its GeoTIFF would reach; in memory
// some 64 MiB (or 4 bytes per cell), whatever overviews it has. Published by rename. Blocking. Errors: kIo,
// kOutOfSpace, kCorrupt, kTooLarge (tiles that lie too far apart, as of the GeoTIFF).
#pragma once

#include <filesystem>

#include "core/base/result.h"

namespace skyquilt::storage {

// longer_side_px: of the picture; a smaller map is not enlarged.
Result<void> WriteThumbnail(const std::filesystem::path& cog, const std::filesystem::path& path,
                            int longer_side_px);
Result<void> WriteTilesThumbnail(const std::filesystem::path& mbtiles, const std::filesystem::path& path,
                                 int longer_side_px);

}  // namespace skyquilt::storage
