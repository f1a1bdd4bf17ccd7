// ImportMap: a map of others (a georeferenced GeoTIFF, an MBTiles of pictures) as the products of a finished
// map in a folder: mosaic.mbtiles, thumbnail.png, report.json, photos.geojson, as
// StitchToDirectory leaves them, without photos. Foreign bytes: run by a user on his own files, or by a
// confined process. Blocking.
// Errors: kUnsupportedFormat, kUnprocessable, kCorrupt, kTooLarge (the message says what to do), kCancelled,
// kOutOfSpace, kIo.
#pragma once

#include <filesystem>
#include <string>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/flight/lists/input_file.h"
#include "core/pipeline/report/mosaic_report.h"

namespace skyquilt::server {

struct ImportOptions {
  std::string title;
  int quality = 85;
  int threads = 0;  // 0 = all cores
};

// Errors and the report call the file by its `name`.
Result<pipeline::MosaicReport> ImportMap(const flight::InputFile& file, const std::filesystem::path& out_dir,
                                         const ImportOptions& options, Progress& progress);

}  // namespace skyquilt::server
