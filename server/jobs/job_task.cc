#include "server/jobs/job_task.h"

#include <algorithm>

#include "api/json/job_options.h"
#include "core/base/try.h"
#include "core/pipeline/units/flight_cut.h"
#include "server/imports/import_map.h"

namespace skyquilt::server {

JobKind KindOf(const std::string& options) {
  const Result<pipeline::MosaicOptions> parsed = api::ParseJobOptions(options);
  if (!parsed) return JobKind::kUsual;
  if (!parsed->import_file.empty()) return JobKind::kImport;
  if (parsed->surface != pipeline::MapGround::kSmooth) return JobKind::kUpright;
  return parsed->heights != pipeline::MapHeights::kNone ? JobKind::kWithHeights : JobKind::kUsual;
}

bool IsMadeWhole(const std::string& options) { return KindOf(options) != JobKind::kUsual; }

Result<LimitedTask> TaskOf(const WorkerContext& context, const std::string& flight_id,
                           const std::string& options, const ShareOfFiles& share, Progress& progress) {
  SKYQUILT_TRY_ASSIGN(const storage::Flight flight, context.catalogue.GetFlight(flight_id));
  SKYQUILT_TRY_ASSIGN(std::vector<storage::StoredFile> files, context.catalogue.ListFiles(flight_id));
  SKYQUILT_TRY_ASSIGN(const pipeline::MosaicOptions parsed, api::ParseJobOptions(options));
  LimitedTask made;
  if (!parsed.import_file.empty())
    std::erase_if(files, [&](const storage::StoredFile& file) {
      return file.name != parsed.import_file && file.name != ReportBeside(parsed.import_file);
    });
  std::int64_t bytes = 0;
  for (const storage::StoredFile& file : files) bytes += file.bytes;
  made.limits = LimitsOfJob(static_cast<std::int64_t>(files.size()), bytes, parsed, context.limits);
  const pipeline::UnitRange range = pipeline::RangeOf(static_cast<std::size_t>(share.number),
                                                      static_cast<std::size_t>(share.count), files.size());
  files = {files.begin() + static_cast<std::ptrdiff_t>(range.first),
           files.begin() + static_cast<std::ptrdiff_t>(range.end)};
  if (share.names) {
    const auto is_other = [&](const storage::StoredFile& file) { return share.names->count(file.name) == 0; };
    files.erase(std::remove_if(files.begin(), files.end(), is_other), files.end());
  }
  made.task.files_dir = context.blobs.FolderOf(storage::FilesPrefix(flight_id));
  made.task.options = options;
  made.task.title = flight.name;
  for (const storage::StoredFile& file : files)
    made.task.files.push_back({file.name, made.task.files_dir / file.stored_name});
  if (!context.blobs.IsFolder()) {
    SKYQUILT_TRY_ASSIGN(made.in_use, FetchFiles(context.blobs, flight_id, files, progress));
  }
  return made;
}

}  // namespace skyquilt::server
