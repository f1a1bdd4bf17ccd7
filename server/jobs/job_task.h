// What a worker asks the sandboxed process that works on a job for (TaskOf), and what the job needs of blobs
// that lie elsewhere than in the data folder, and leaves there. A store that is away is waited for, within
// bounds, while the job is wanted. Blocking. Errors: those of the catalogue and of blobs; kInvalidArgument
// (the options); kCancelled.
#pragma once

#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "server/jobs/child_messages.h"
#include "server/jobs/job_limits.h"
#include "server/jobs/job_progress.h"
#include "server/jobs/worker_context.h"
#include "storage/blobs/blob_store.h"
#include "storage/catalogue/catalogue.h"

namespace skyquilt::server {

// What the system said of a file of a map, of a part of one or of its folder: kOutOfSpace where the disk is
// full, else kIo.
Error MapNotStored(const std::string& what, int number);

// The files stay on this machine for as long as this lives.
using FilesInUse = std::vector<storage::LocalBlob>;

// What the next map takes over from the one that is shown: its tiles and its memory.
Result<FilesInUse> FetchMap(storage::BlobStore& blobs, const std::string& prefix, Progress& progress);

// All blobs whose keys begin so.
Result<FilesInUse> FetchBelow(storage::BlobStore& blobs, const std::string& prefix, Progress& progress);

// All files of a folder and those below, under a prefix. What was put stays if this fails.
Result<void> PutProducts(storage::BlobStore& blobs, const std::filesystem::path& folder,
                         const std::string& prefix, Progress& progress);

struct LimitedTask {
  StitchTask task;    // without folders of its own
  JobLimits limits;   // of the whole flight
  FilesInUse in_use;  // what was fetched for it
};

// One of `count` nearly equal shares of a flight's files, in the order of their names; or those of `names`.
struct ShareOfFiles {
  int number = 0;
  int count = 1;
  std::optional<std::set<std::string>> names = std::nullopt;
};

JobKind KindOf(const std::string& options);
// Units of other machines know nothing of it.
bool IsMadeWhole(const std::string& options);

// The flight's files, or the one that is to be imported with the report beside it, where they are on this
// machine (fetched, where photos lie elsewhere), the options, and the limits.
Result<LimitedTask> TaskOf(const WorkerContext& context, const std::string& flight_id,
                           const std::string& options, const ShareOfFiles& share, Progress& progress);

}  // namespace skyquilt::server
