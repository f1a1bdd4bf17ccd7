// How a job is read from its row: the columns and their order, in one place for the files of the queue. Any
// thread.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "storage/db/sql_connection.h"
#include "storage/jobs/job_queue.h"

namespace skyquilt::storage {

inline constexpr const char* kJobColumns =
    "SELECT id, flight_id, options, stage, progress, message, attempts, cancel, created_us, started_us,"
    " attempt_started_us, finished_us, priority, state, error_code, error_message, error_reason, expected_s,"
    " expected_low_s, expected_high_s ";

// A job that waits for its units has this worker, "units", and a lease that never ends by itself.
inline constexpr std::int64_t kUnitsLeaseUs = std::int64_t{1} << 53;

Job JobFrom(const Statement& row);

// As SQL: the end of a lease that the parameter has ("?3"). PostgreSQL gives it no less than half of a
// lease's time from when it writes it: a claim or renewal that lay before a frozen server would be over when
// it is heard.
std::string LeaseEndSql(const SqlConnection& db, std::string_view parameter);

// What is stored of why something failed: the remark in JSON; empty where the message alone tells.
std::string ReasonText(const Error& error);

// Of a row of id, flight, options, token and attempts.
Lease LeaseFrom(const Statement& row);
// Of a query for `cancel` of a job that is held.
Result<LeaseState> LeaseStateFrom(Statement& query);

}  // namespace skyquilt::storage
