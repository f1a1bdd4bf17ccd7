// ImportMap: a map of others (a georeferenced GeoTIFF, an MBTiles of pictures) as the products of a finished
// map in a folder: mosaic.mbtiles, thumbnail.png, report.json, photos.geojson, as
// StitchToDirectory leaves them, without photos. How true it is, the report that lay beside it says where it
// is of this map (told_quality.h); nobody knows otherwise. Foreign bytes: run by a user on his own files, or
// by a sandboxed process. Blocking. Errors: kUnsupportedFormat, kUnprocessable, kCorrupt, kTooLarge (the
// message says what to do), kCancelled, kOutOfSpace, kIo.
#pragma once

#include <filesystem>
#include <string>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/flight/bytes/input_file.h"
#include "core/pipeline/report/mosaic_report.h"

namespace skyquilt::server {

struct ImportOptions {
  std::string title;
  int quality = 85;
  int threads = 0;                    // 0 = all cores
  std::filesystem::path report_json;  // that came with the file; empty or missing: none
};

// Where the report of a map lies that Skyquilt made: beside its file.
std::filesystem::path ReportBeside(const std::filesystem::path& file);
// Empty where it is none of a map of ours.
std::string ReportText(const std::filesystem::path& file);

// Errors and the report call the file by its `name`.
Result<pipeline::MosaicReport> ImportMap(const flight::InputFile& file, const std::filesystem::path& out_dir,
                                         const ImportOptions& options, Progress& progress);

}  // namespace skyquilt::server
