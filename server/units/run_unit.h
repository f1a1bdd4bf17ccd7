// RunUnit: one leased unit of a cut job, by a sandboxed process (server/jobs/stitch_sandboxed.h) that writes
// into the unit's folder. In every case the unit ends or returns to the queue. Blocking; any thread that
// lives as long.
#pragma once

#include "server/jobs/worker_context.h"
#include "storage/jobs/unit_queue.h"

namespace skyquilt::server {

void RunUnit(WorkerContext& context, const storage::UnitLease& unit);

}  // namespace skyquilt::server
