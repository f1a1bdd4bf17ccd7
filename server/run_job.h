// RunJob: one leased job from its files to a published revision. The products are made in a folder of the
// lease's own below work/, moved into the flight in one step, and shown only if the lease still holds.
// Whatever happens, the job ends or goes back to the queue, and the work folder is removed. Blocking; one at
// a time in a process.
#pragma once

#include <atomic>

#include "storage/catalogue.h"
#include "storage/data_dir.h"
#include "storage/job_queue.h"

namespace skyquilt::server {

struct WorkerContext {
  const storage::DataDir& dir;
  storage::Catalogue& catalogue;
  storage::JobQueue& queue;
  storage::StageCosts& costs;
  const std::atomic<bool>& is_stopping;
  // This process is one of a server's own, which starts another: a cancelled job that does not stop in time
  // may end it. What it leaves behind the server removes.
  bool may_exit = false;
};

// How such a process ends.
inline constexpr int kCancelledExitCode = 3;

void RunJob(WorkerContext& context, const storage::Lease& lease);

}  // namespace skyquilt::server
