#include "server/imports/import_for_job.h"

#include <algorithm>
#include <system_error>

#include "core/base/try.h"
#include "core/flight/remarks/because.h"
#include "server/imports/import_map.h"
#include "storage/exports/pmtiles_writer.h"

namespace skyquilt::server {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kKeepFreeBytes = std::int64_t{512} << 20;
constexpr std::int64_t kMinRoomBytes = std::int64_t{1} << 20;

}  // namespace

std::int64_t RoomForImport(const fs::path& folder) {
  std::error_code unknown;
  const fs::space_info disk = fs::space(folder, unknown);
  if (unknown) return kMinRoomBytes;
  return std::max(kMinRoomBytes, static_cast<std::int64_t>(disk.available) - kKeepFreeBytes);
}

Result<pipeline::MosaicReport> ImportForJob(const std::vector<flight::InputFile>& files,
                                            const pipeline::MosaicOptions& options, const ImportJob& job,
                                            Progress& progress) {
  const auto file = std::find_if(files.begin(), files.end(), [&](const flight::InputFile& one) {
    return one.name == options.import_file;
  });
  if (file == files.end())
    return flight::Because(ErrorCode::kUnprocessable,
                           {flight::RemarkCode::kFailImportMissing, {{"file", options.import_file}}});
  const auto told = std::find_if(files.begin(), files.end(), [&](const flight::InputFile& one) {
    return fs::path(one.name) == ReportBeside(file->name);
  });
  const ImportOptions how{options.title, options.jpeg_quality, options.threads,
                          told == files.end() ? fs::path() : told->path};
  Result<pipeline::MosaicReport> report = ImportMap(*file, job.out_dir, how, progress);
  if (report && job.with_pmtiles) {
    SKYQUILT_TRY(
        storage::WritePmtiles(job.out_dir / "mosaic.mbtiles", job.out_dir / "mosaic.pmtiles", progress));
  }
  return report;
}

}  // namespace skyquilt::server
