// What becomes of a job whose worker is gone: another attempt where the worker died while others went on
// living, none where the machine or the server was taken from under it. Claims, renewals and ends of leases
// are JobQueue's (job_queue.h), the workers' half of which stands in the source beside this header.
#pragma once

#include "core/base/result.h"
#include "storage/db/clock.h"
#include "storage/db/sql_connection.h"
#include "storage/jobs/job_queue.h"

namespace skyquilt::storage {

// Leases that ran out: of jobs whose user wished to cancel, of claims that a restart cut off, and of the last
// attempt. Called with the write lock held. Errors: as SqlConnection.
Result<void> SettleLostLeases(SqlConnection& db, Time now);

}  // namespace skyquilt::storage
