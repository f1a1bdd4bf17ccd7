// WritePmtiles: a finished MBTiles of MbtilesWriter as a PMTiles archive (version 3): the same bytes,
// clustered along the Hilbert curve, each once. A browser reads single tiles from it on any file server with
// range requests. Streams; memory is 40 bytes per tile. Published by rename. Blocking. Errors: kIo,
// kOutOfSpace, kCorrupt, kCancelled. Source: PMTiles specification version 3.
#pragma once

#include <filesystem>

#include "core/base/progress.h"
#include "core/base/result.h"

namespace skyquilt::storage {

Result<void> WritePmtiles(const std::filesystem::path& mbtiles, const std::filesystem::path& path,
                          Progress& progress);

}  // namespace skyquilt::storage
