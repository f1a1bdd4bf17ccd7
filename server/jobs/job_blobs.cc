#include "server/jobs/job_blobs.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <mutex>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>

#include "core/base/parallel_for.h"
#include "core/base/try.h"
#include "core/flight/remarks/because.h"
#include "storage/files/data_dir.h"

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
    if (progress.IsCancelled()) return Error{ErrorCode::kCancelled, "The job was cancelled.", ""};
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
  std::optional<Error> failure;
  std::size_t done = 0;
  ParallelFor(count, kSideBySide, [&](std::size_t i) {
    {
      const std::lock_guard lock(mutex);
      if (failure) return;
    }
    const Result<void> acted = WithPatience(progress, [&] { return act(i); });
    const std::lock_guard lock(mutex);
    if (!acted && !failure) failure = acted.error();
    ++done;
    progress.Report(static_cast<double>(done) / static_cast<double>(count),
                    fmt::format(fmt::runtime(what), done, count));
  });
  if (failure) return *failure;
  return {};
}

}  // namespace

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
  if (error) return flight::Because(ErrorCode::kIo, flight::RemarkCode::kFailNotStored, error.message());
  std::sort(files.begin(), files.end());
  progress.BeginStage("store");
  return ForAll(files.size(), "{} of {} files of the map stored", progress, [&](std::size_t i) {
    return blobs.Put(prefix + files[i].lexically_relative(folder).generic_string(), files[i]);
  });
}

}  // namespace skyquilt::server
