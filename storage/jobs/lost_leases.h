// What becomes of a job whose worker is gone: another attempt where the worker died while others went on
// living, none where the machine or the server was taken from under it. Called with the write lock held.
// Errors: as SqlConnection.
#pragma once

#include "core/base/result.h"
#include "storage/db/clock.h"
#include "storage/db/sql_connection.h"
#include "storage/jobs/job_queue.h"

namespace skyquilt::storage {

// A claim was cut off from outside: the attempt does not count, the interruption does; of kMaxInterruptions
// the last ends the job. Goes between "UPDATE job SET" and "WHERE state='running'"; parameter ?1 is the time.
inline constexpr const char* kInterrupt =
    " attempts=attempts-1, interruptions=interruptions+1, not_before_us=0, worker='',"
    " state=CASE WHEN cancel=1 THEN 'dismissed' WHEN interruptions+1>=10 THEN 'failed' ELSE 'accepted' END,"
    " finished_us=CASE WHEN cancel=1 OR interruptions+1>=10 THEN ?1 ELSE NULL END,"
    " error_code=CASE WHEN interruptions+1>=10 THEN 'unavailable' ELSE error_code END,"
    " error_message=CASE WHEN interruptions+1>=10 THEN 'This job was interrupted 10 times by restarts of the server or the"
    " machine, and is not begun again by itself. If it was the job that brought the machine down, try fewer or smaller"
    " photos; if not, start it again.' ELSE error_message END ";
static_assert(kMaxInterruptions == 10, "the statement above names it");

// Leases that ran out: of jobs whose user wished to cancel, of claims that a restart cut off, and of the last
// attempt.
Result<void> SettleLostLeases(SqlConnection& db, Time now);

}  // namespace skyquilt::storage
