// ExportTask: what a server tells the sandboxed process that makes an export, as a JSON text. What that
// process says are JobMessages (server/jobs/job_messages.h). Pure. Error: kUnprocessable.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "core/base/result.h"

namespace skyquilt::server {

struct ExportTask {
  std::filesystem::path map_dir;   // mosaic.mbtiles, report.json, perhaps mosaic.tif or bands.tif
  std::filesystem::path work_dir;  // all that it may write below
  std::string out_name;            // of the file that it leaves there
  std::string request;             // as storage::ParseExportRequest reads it
  int threads = 1;
  std::int64_t memory_bytes = 0;  // that it may write, beyond the program's own
  std::int64_t cpu_s = 0;
  std::int64_t file_bytes = 0;  // of any one file
};

std::string ToText(const ExportTask& task);
Result<ExportTask> ParseExportTask(std::string_view text);

}  // namespace skyquilt::server
