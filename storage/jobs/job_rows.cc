#include "storage/jobs/job_rows.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "core/base/check.h"
#include "core/base/text/json_io.h"
#include "core/base/try.h"
#include "core/flight/remarks/because.h"
#include "core/flight/remarks/remark_json.h"

namespace skyquilt::storage {
namespace {

JobState StateFrom(std::string_view name) {
  for (const JobState state : {JobState::kAccepted, JobState::kRunning, JobState::kSuccessful,
                               JobState::kFailed, JobState::kDismissed}) {
    if (name == JobStateName(state)) return state;
  }
  SKYQUILT_CHECK(false, "the schema allows no other job state");
}

std::optional<Time> TimeFrom(const Statement& row, int column) {
  if (row.IsNull(column)) return std::nullopt;
  return FromUs(row.ColumnInt64(column));
}

}  // namespace

Job JobFrom(const Statement& row) {
  Job job;
  job.id = row.ColumnText(0);
  job.flight_id = row.ColumnText(1);
  job.options = row.ColumnText(2);
  job.state = StateFrom(row.ColumnText(3));
  job.stage = row.ColumnText(4);
  job.progress = row.ColumnDouble(5);
  job.message = row.ColumnText(6);
  job.attempts = static_cast<int>(row.ColumnInt64(7));
  job.cancel_requested = row.ColumnInt64(8) != 0;
  if (!row.IsNull(9)) {
    job.error = JobError{std::string(row.ColumnText(9)), std::string(row.ColumnText(10)),
                         std::string(row.ColumnText(19))};
  }
  job.created = FromUs(row.ColumnInt64(11));
  job.started = TimeFrom(row, 12);
  job.attempt_started = TimeFrom(row, 13);
  job.finished = TimeFrom(row, 14);
  job.priority = static_cast<int>(row.ColumnInt64(15));
  if (!row.IsNull(16))
    job.expected = Expectation{row.ColumnDouble(16), row.ColumnDouble(17), row.ColumnDouble(18), {}};
  return job;
}

std::string LeaseEndSql(const SqlConnection& db, std::string_view parameter) {
  if (db.dialect() != Dialect::kPostgres) return std::string(parameter);
  return fmt::format("greatest({}, now_us()+{})", parameter,
                     std::chrono::microseconds(kLeaseTime).count() / 2);
}

std::string ReasonText(const Error& error) {
  if (!flight::HasReason(error)) return "";
  using Json = nlohmann::ordered_json;
  return JsonText(flight::JsonOfRemark<Json>(flight::WhyOf(error)));
}

Lease LeaseFrom(const Statement& row) {
  return {std::string(row.ColumnText(0)), std::string(row.ColumnText(1)), std::string(row.ColumnText(2)),
          row.ColumnInt64(3), static_cast<int>(row.ColumnInt64(4))};
}

Result<LeaseState> LeaseStateFrom(Statement& query) {
  SKYQUILT_TRY_ASSIGN(const bool row, query.Step());
  if (!row) return LeaseState::kLost;
  return query.ColumnInt64(0) != 0 ? LeaseState::kCancelRequested : LeaseState::kHeld;
}

}  // namespace skyquilt::storage
