// From a map of others to a tileset of ours (server/imports/import_map.h). Each fills in what the report says
// of the map's ground and tiles. Blocking. Errors: kCancelled, kOutOfSpace, kIo, and those named below.
#pragma once

#include <filesystem>
#include <string>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/flight/bytes/input_file.h"
#include "core/pipeline/report/mosaic_report.h"
#include "server/imports/import_map.h"
#include "storage/tilesets/mbtiles_writer.h"

namespace skyquilt::server {

// A georeferenced GeoTIFF: tiles of its own resolution and overviews down to the one tile that holds it all.
// Memory: GDAL's caches, sixteen tiles, and one open parent a zoom. Errors: those of storage::MapRaster,
// kUnprocessable (nothing of it is covered).
Result<void> ImportRaster(const flight::InputFile& file, const std::filesystem::path& mbtiles,
                          const ImportOptions& options, pipeline::MosaicReport& report, Progress& progress);

// The tiles of an MBTiles, byte for byte but for JPEGs that are grey or RGB, which no GeoTIFF shows. Each is
// decoded once, so that what is served afterwards is known to be pictures of one size. Memory: one tile.
// Errors: kUnsupportedFormat (no MBTiles; vector tiles; another grid), kCorrupt (damaged), kTooLarge.
Result<void> ImportTiles(const flight::InputFile& file, const std::filesystem::path& mbtiles,
                         pipeline::MosaicReport& report, Progress& progress);

// What such a tileset says of itself.
storage::TilesetMetadata MetadataOfImport(const pipeline::MosaicReport& report,
                                          const std::string& attribution);

}  // namespace skyquilt::server
