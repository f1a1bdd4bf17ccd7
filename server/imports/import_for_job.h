// ImportForJob: the finished map of others among the files of a job (its option "import_file") as the
// products of the flight's map. Foreign bytes: run by the sandboxed process of a job, whose files may grow to
// RoomForImport: a small file may describe a map of any size. Blocking. Errors: those of ImportMap, in the
// words of the file's own name; kUnprocessable (the flight has no such file).
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

namespace skyquilt::server {

struct ImportJob {
  std::filesystem::path out_dir;
  bool with_pmtiles = false;  // the map is to lie where its tiles are read by ranges
};

// What an import may take of the disk of a folder, which others need too.
std::int64_t RoomForImport(const std::filesystem::path& folder);

// `options.import_file` names one of `files`.
Result<pipeline::MosaicReport> ImportForJob(const std::vector<flight::InputFile>& files,
                                            const pipeline::MosaicOptions& options, const ImportJob& job,
                                            Progress& progress);

}  // namespace skyquilt::server
