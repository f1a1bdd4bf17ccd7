// JobQueue::Claim in each engine: the job whose turn it is. Priority first; among equals who has fewest jobs
// running now, then whose last turn is longest ago, then the job that came first. A job whose worker's lease
// ran out waits like the others. Errors: kUnavailable, kIo.
#pragma once

#include <optional>
#include <string_view>

#include "core/base/result.h"
#include "storage/db/clock.h"
#include "storage/db/sql_connection.h"
#include "storage/jobs/job_queue.h"

namespace skyquilt::storage {

// Absent: nothing waits, or nothing that may begin already. Reads one row for each owner that has a job
// running and at one more, however many wait.
Result<std::optional<Lease>> ClaimInFolder(SqlConnection& db, std::string_view worker, Time now);

// Where many machines claim at once: one call of claim_job (storage/db/postgres/functions_postgres.sql),
// which passes over what others are claiming. Leases that ran out are settled first, by one claim at a time;
// what remains of them waits again like any other job. By the database's clock: `now`, and before when leases
// must have ended that are lost.
Result<std::optional<Lease>> ClaimInPostgres(SqlConnection& db, std::string_view worker, Time now,
                                             Time lost_before);

// Nobody could renew a lease while the database was down: those of jobs and units that ran out meanwhile have
// their time once more, from the start of the database. Those that were released (no worker) stay released.
Result<void> GiveTimeAfterStart(SqlConnection& db, Time now);

}  // namespace skyquilt::storage
