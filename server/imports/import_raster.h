// ImportRaster: a georeferenced GeoTIFF as a tileset: tiles of its own resolution and overviews down to the
// one tile that holds it all. Memory: GDAL's caches, sixteen tiles, and one open parent a zoom. Blocking.
// Errors: those of storage::MapRaster, kUnprocessable (nothing of it is covered), kCancelled, kOutOfSpace,
// kIo.
#pragma once

#include <filesystem>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/flight/bytes/input_file.h"
#include "core/pipeline/report/mosaic_report.h"
#include "server/imports/import_map.h"

namespace skyquilt::server {

// Fills in what the report says of the map's ground and tiles.
Result<void> ImportRaster(const flight::InputFile& file, const std::filesystem::path& mbtiles,
                          const ImportOptions& options, pipeline::MosaicReport& report, Progress& progress);

}  // namespace skyquilt::server
