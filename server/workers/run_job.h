// RunJob: one leased job from its files to a published revision. The products are made by a sandboxed process
// (server/jobs/stitch_sandboxed.h) in a folder of the lease's own below work/, of which only plain files are
// used; they are moved into the flight in one step (where maps lie elsewhere: all of them are put there
// first), and shown only if the lease still holds. In every case the job ends or returns to the queue; the
// work folder is removed, unless the process died or was stopped and another attempt continues from it.
// Blocking; any thread that lives as long.
#pragma once

#include "server/jobs/worker_context.h"
#include "storage/jobs/job_queue.h"

namespace skyquilt::server {

void RunJob(WorkerContext& context, const storage::Lease& lease);

}  // namespace skyquilt::server
