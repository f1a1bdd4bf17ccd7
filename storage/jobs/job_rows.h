// How a job is read from its row: the columns and their order, in one place for the files of the queue. Any
// thread.
#pragma once

#include "storage/db/statement.h"
#include "storage/jobs/job_queue.h"

namespace skyquilt::storage {

inline constexpr const char* kJobColumns =
    "SELECT id, flight_id, options, state, stage, progress, message, attempts, cancel, error_code, "
    "error_message,"
    " created_us, started_us, attempt_started_us, finished_us, priority, expected_s, expected_low_s, expected_high_s ";

Job JobFrom(const Statement& row);

}  // namespace skyquilt::storage
