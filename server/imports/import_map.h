// ImportMap: a map of others (a georeferenced GeoTIFF, an MBTiles of pictures) as the products of a finished
// map in a folder: mosaic.mbtiles, thumbnail.png, report.json, photos.geojson, as
// StitchToDirectory leaves them, without photos. How true it is, the report that lay beside it says where it
// is of this map (told_quality.h); nobody knows otherwise. Foreign bytes: run by a user on his own files, or
// by a sandboxed process. Blocking. Errors: kUnsupportedFormat, kUnprocessable, kCorrupt, kTooLarge (the
// message says what to do), kCancelled, kOutOfSpace, kIo.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/flight/bytes/input_file.h"
#include "core/pipeline/mosaic_options.h"
#include "core/pipeline/report/mosaic_report.h"

namespace skyquilt::storage {
struct OpenedDataFolder;
}

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

struct ImportJob {
  std::filesystem::path out_dir;
  bool with_pmtiles = false;  // the map is to lie where its tiles are read by ranges
};

// What an import may take of the disk of a folder, which others need too: a small file may describe a map of
// any size.
std::int64_t RoomForImport(const std::filesystem::path& folder);

// The same of a job, in its sandboxed process: `options.import_file` names one of `files`. Errors: also
// kUnprocessable (the flight has no such file).
Result<pipeline::MosaicReport> ImportForJob(const std::vector<flight::InputFile>& files,
                                            const pipeline::MosaicOptions& options, const ImportJob& job,
                                            Progress& progress);

// The products of a map as the first map of a new flight in a data folder, durable when this returns. The
// caller holds the folder (OpenDataFolder). `products`: a folder on the same disk, which becomes the map's.
// The id of the flight. What fails leaves nothing that is shown. Errors: kIo, kOutOfSpace, those of the
// catalogue.
Result<std::string> EnterMap(const storage::OpenedDataFolder& opened, const std::filesystem::path& products,
                             const std::string& name, const std::vector<std::string>& tags);

}  // namespace skyquilt::server
