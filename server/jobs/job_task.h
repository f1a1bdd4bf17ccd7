// KindOf: what a job's options make of it. IsMadeWhole: one that units of other machines know nothing of.
// TaskOf: what a worker asks the sandboxed process that works on a job for: the flight's files, or the one
// that is to be imported with the report beside it, where they are on this machine (fetched, where photos lie
// elsewhere), the options, and the limits. Blocking. Errors: those of the catalogue and of blobs;
// kInvalidArgument (the options); kCancelled.
#pragma once

#include <optional>
#include <set>
#include <string>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "server/jobs/job_blobs.h"
#include "server/jobs/job_limits.h"
#include "server/jobs/job_messages.h"
#include "server/jobs/worker_context.h"

namespace skyquilt::server {

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

enum class JobKind {
  kUsual,
  kImport,       // takes over a map of others (import_file)
  kUpright,      // heights are matched before the map is drawn (surface)
  kWithHeights,  // and after it (heights)
};
JobKind KindOf(const std::string& options);
bool IsMadeWhole(const std::string& options);

Result<LimitedTask> TaskOf(const WorkerContext& context, const std::string& flight_id,
                           const std::string& options, const ShareOfFiles& share, Progress& progress);

}  // namespace skyquilt::server
