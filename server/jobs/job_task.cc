#include "server/jobs/job_task.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <functional>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>

#include "api/json/job_options.h"
#include "core/base/parallel_for.h"
#include "core/base/try.h"
#include "core/flight/remarks/because.h"
#include "core/pipeline/units/flight_cut.h"
#include "server/imports/import_map.h"
#include "storage/files/data_dir.h"
#include "storage/files/publish_file.h"

namespace skyquilt::server {
namespace {

namespace fs = std::filesystem;

// Requests wait for the network, not for the processor.
constexpr int kSideBySide = 8;
constexpr std::chrono::minutes kBlobPatience{15};
constexpr std::chrono::seconds kBlobPause{2};

// Again and again while the store is away.
Result<void> WithPatience(const Progress& progress, const std::function<Result<void>()>& act) {
  const auto deadline = std::chrono::steady_clock::now() + kBlobPatience;
  while (true) {
    if (progress.IsCancelled()) return Error{ErrorCode::kCancelled, "The job was cancelled."};
    Result<void> done = act();
    const bool may_wait = !done && done.error().code == ErrorCode::kUnavailable;
    if (!may_wait || std::chrono::steady_clock::now() > deadline) return done;
    std::this_thread::sleep_for(kBlobPause);
  }
}

// Each of several things, some side by side; the first error ends it.
Result<void> ForAll(std::size_t count, const char* what, Progress& progress,
                    const std::function<Result<void>(std::size_t)>& act) {
  std::mutex mutex;
  std::size_t done = 0;
  return ParallelTry(count, kSideBySide, [&](std::size_t i) -> Result<void> {
    SKYQUILT_TRY(WithPatience(progress, [&] { return act(i); }));
    const std::lock_guard lock(mutex);
    ++done;
    progress.Report(static_cast<double>(done) / static_cast<double>(count),
                    fmt::format(fmt::runtime(what), done, count));
    return {};
  });
}

// A flight's files into this machine's cache, side by side.
Result<FilesInUse> FetchFiles(storage::BlobStore& blobs, const std::string& flight_id,
                              const std::vector<storage::StoredFile>& files, Progress& progress) {
  FilesInUse fetched(files.size());
  const std::string prefix = storage::FilesPrefix(flight_id);
  progress.BeginStage("fetch");
  SKYQUILT_TRY(ForAll(files.size(), "{} of {} files fetched", progress, [&](std::size_t i) -> Result<void> {
    SKYQUILT_TRY_ASSIGN(fetched[i], blobs.Local(prefix + files[i].stored_name));
    return {};
  }));
  return fetched;
}

}  // namespace

Error MapNotStored(const std::string& what, int number) {
  const bool is_full = storage::IsNoRoom(number);
  return flight::Because(is_full ? ErrorCode::kOutOfSpace : ErrorCode::kIo,
                         is_full ? flight::RemarkCode::kFailDiskFull : flight::RemarkCode::kFailNotStored,
                         what + ": " + std::strerror(number));
}

Result<FilesInUse> FetchMap(storage::BlobStore& blobs, const std::string& prefix, Progress& progress) {
  FilesInUse fetched;
  for (const char* name : {"mosaic.state", "mosaic.mbtiles"}) {
    SKYQUILT_TRY(WithPatience(progress, [&]() -> Result<void> {
      Result<storage::LocalBlob> file = blobs.Local(prefix + name);
      // A map without a memory is made anew.
      if (!file && file.error().code == ErrorCode::kNotFound) return {};
      if (!file) return file.error();
      fetched.push_back(*std::move(file));
      return {};
    }));
  }
  return fetched;
}

Result<FilesInUse> FetchBelow(storage::BlobStore& blobs, const std::string& prefix, Progress& progress) {
  std::vector<storage::BlobInfo> listed;
  SKYQUILT_TRY(WithPatience(progress, [&]() -> Result<void> {
    SKYQUILT_TRY_ASSIGN(listed, blobs.List(prefix));
    return {};
  }));
  FilesInUse fetched(listed.size());
  progress.BeginStage("fetch");
  SKYQUILT_TRY(ForAll(listed.size(), "{} of {} parts fetched", progress, [&](std::size_t i) -> Result<void> {
    SKYQUILT_TRY_ASSIGN(fetched[i], blobs.Local(listed[i].key));
    return {};
  }));
  return fetched;
}

Result<void> PutProducts(storage::BlobStore& blobs, const fs::path& folder, const std::string& prefix,
                         Progress& progress) {
  std::vector<fs::path> files;
  std::error_code error;
  for (const auto& entry : fs::recursive_directory_iterator(folder, error)) {
    if (entry.is_regular_file(error)) files.push_back(entry.path());
  }
  if (error) return MapNotStored("list " + folder.string(), error.value());
  std::sort(files.begin(), files.end());
  progress.BeginStage("store");
  return ForAll(files.size(), "{} of {} files of the map stored", progress, [&](std::size_t i) {
    return blobs.Put(prefix + files[i].lexically_relative(folder).generic_string(), files[i]);
  });
}

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
  std::int64_t bytes = 0, photos = 0;
  for (const storage::StoredFile& file : files) {
    bytes += file.bytes;
    photos += MostPhotosIn(file.name, file.bytes);
  }
  made.limits = LimitsOfJob(photos, bytes, parsed, context.limits);
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
