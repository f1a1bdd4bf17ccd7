// ImportTiles: the tiles of an MBTiles of others, byte for byte, into a tileset of ours. Each is decoded
// once, so that what is served afterwards is known to be pictures of one size. Memory: one tile. Blocking.
// Errors: kUnsupportedFormat (no MBTiles; vector tiles; another grid), kCorrupt (damaged), kTooLarge,
// kCancelled, kOutOfSpace, kIo.
#pragma once

#include <filesystem>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/flight/bytes/input_file.h"
#include "core/pipeline/report/mosaic_report.h"

namespace skyquilt::server {

// Fills in what the report says of the map's ground and tiles.
Result<void> ImportTiles(const flight::InputFile& file, const std::filesystem::path& mbtiles,
                         pipeline::MosaicReport& report, Progress& progress);

}  // namespace skyquilt::server
