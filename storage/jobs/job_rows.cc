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

}  // namespace

Job JobFrom(const Statement& row) {
  Job job;
  row.Into(job.id, job.flight_id, job.options, job.stage, job.progress, job.message, job.attempts,
           job.cancel_requested, job.created, job.started, job.attempt_started, job.finished, job.priority);
  job.state = StateFrom(row.ColumnText(13));
  if (!row.IsNull(14))
    job.error = JobError{row.Get<std::string>(14), row.Get<std::string>(15), row.Get<std::string>(16)};
  if (!row.IsNull(17))
    job.expected = Expectation{row.ColumnDouble(17), row.ColumnDouble(18), row.ColumnDouble(19), {}};
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
  return RowOf<Lease, std::string, std::string, std::string, std::int64_t, int>(row);
}

Result<LeaseState> LeaseStateFrom(Statement& query) {
  SKYQUILT_TRY_ASSIGN(const bool row, query.Step());
  if (!row) return LeaseState::kLost;
  return query.ColumnInt64(0) != 0 ? LeaseState::kCancelRequested : LeaseState::kHeld;
}

}  // namespace skyquilt::storage
