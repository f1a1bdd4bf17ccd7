// ClaimInPostgres: JobQueue::Claim where many machines claim at once: one call of claim_job
// (storage/db/postgres/functions_postgres.sql), which passes over what others are claiming. Leases that ran
// out are settled first, by one claim at a time; what remains of them waits again like any other job. Errors:
// kUnavailable, kIo.
#pragma once

#include <optional>
#include <string_view>

#include "storage/db/sql_connection.h"
#include "storage/jobs/job_queue.h"

namespace skyquilt::storage {

// Nobody could renew a lease while the database was down: those of jobs and units that ran out meanwhile have
// their time once more, from the start of the database. Those that were released (no worker) stay released.
Result<void> GiveTimeAfterStart(SqlConnection& db, Time now);

// By the database's clock: `now`, and before when leases must have ended that are lost.
Result<std::optional<Lease>> ClaimInPostgres(SqlConnection& db, std::string_view worker, Time now,
                                             Time lost_before);

}  // namespace skyquilt::storage
