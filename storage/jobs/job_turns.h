// NextJob: the job whose turn it is. Priority first; among equals who has fewest jobs running now, then whose
// last turn is longest ago, then the job that came first. A job whose worker's lease ran out waits like the
// others. Reads one row for each owner that has a job running and at one more, however many wait. Within
// the caller's transaction. Errors: kUnavailable, kIo.
#pragma once

#include <optional>
#include <string>

#include "core/base/result.h"
#include "storage/db/clock.h"
#include "storage/db/sql_connection.h"

namespace skyquilt::storage {

// Absent: nothing waits, or nothing that may begin already.
Result<std::optional<std::string>> NextJob(SqlConnection& db, Time now);

}  // namespace skyquilt::storage
