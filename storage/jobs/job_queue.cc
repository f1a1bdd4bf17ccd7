#include "storage/jobs/job_queue.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "core/base/try.h"
#include "core/flight/remarks/because.h"
#include "storage/catalogue/cancel_jobs.h"
#include "storage/db/ids.h"
#include "storage/jobs/job_rows.h"

namespace skyquilt::storage {
namespace {

Error NoSuchJob(const std::string& id) {
  return {ErrorCode::kNotFound, fmt::format("There is no job {}.", id), ""};
}

// A job of a flight in the trash is as gone as its flight.
constexpr const char* kOfFlightThere =
    "EXISTS(SELECT 1 FROM flight f WHERE f.id=job.flight_id AND f.deleted_us IS NULL)";

Result<Job> ReadJob(SqlConnection& db, const std::string& id) {
  return db.One(JobFrom, NoSuchJob(id),
                std::string(kJobColumns) + "FROM job WHERE id=? AND " + kOfFlightThere, id);
}

}  // namespace

const char* JobStateName(JobState state) {
  constexpr std::array kNames = {"accepted", "running", "successful", "failed", "dismissed"};
  return kNames[static_cast<std::size_t>(state)];
}

std::string WorkName(const Lease& lease) { return fmt::format("{}-{}", lease.job_id, lease.token); }

std::string JobOfWorkName(const std::string& work_name) {
  const std::size_t dash = work_name.rfind('-');
  return dash == std::string::npos ? std::string() : work_name.substr(0, dash);
}

Result<Job> JobQueue::Add(const std::string& flight_id, const std::string& options, Time by_machine,
                          const JobTurn& turn) {
  return db_.Again([&]() -> Result<Job> {
    const auto db = db_.Lock();
    const Time now = db_.SharedTime(by_machine, *db);
    SKYQUILT_TRY_ASSIGN(Transaction transaction, Transaction::Begin(*db, flight_id));
    Job job;
    job.id = NewId();
    job.flight_id = flight_id;
    job.options = options;
    job.created = now;
    job.priority = turn.priority;
    SKYQUILT_TRY(RequireFlight(*db, flight_id));
    SKYQUILT_TRY_ASSIGN(
        const bool has_unfinished,
        db->Finds("SELECT 1 FROM job WHERE flight_id=? AND state IN ('accepted','running')", flight_id));
    if (has_unfinished) {
      return flight::Because(ErrorCode::kConflict, flight::RemarkCode::kFailUnfinishedJob);
    }
    SKYQUILT_TRY(
        db->Change("INSERT INTO job(id,flight_id,options,state,created_us,max_attempts,priority,owner)"
                   " VALUES(?,?,?,'accepted',?,?,?,?)",
                   job.id, flight_id, options, ToUs(now), kMaxAttempts, turn.priority, turn.owner));
    SKYQUILT_TRY(transaction.Commit());
    return job;
  });
}

Result<Job> JobQueue::Get(const std::string& id) const {
  const auto db = db_.Read();
  return ReadJob(*db, id);
}

Result<std::vector<Job>> JobQueue::List(const std::optional<std::string>& flight_id, int limit,
                                        const std::optional<std::string>& cursor) const {
  const auto db = db_.Read();
  // Two statements, so that each has its index.
  return db->All(
      JobFrom,
      std::string(kJobColumns) +
          (flight_id ? "FROM job WHERE flight_id=?1 AND " : "FROM job WHERE CAST(?1 AS TEXT) IS NULL AND ") +
          "(CAST(?3 AS TEXT) IS NULL OR id<?3) AND " + kOfFlightThere + " ORDER BY id DESC LIMIT ?2",
      flight_id, limit, cursor);
}

Result<std::optional<Job>> JobQueue::LatestOf(const std::string& flight_id) const {
  const auto db = db_.Read();
  return db->First(JobFrom,
                   std::string(kJobColumns) + "FROM job WHERE flight_id=? AND " + kOfFlightThere +
                       " ORDER BY id DESC LIMIT 1",
                   flight_id);
}

Result<std::vector<Job>> JobQueue::ListRunning() const {
  const auto db = db_.Read();
  return db->All(JobFrom, std::string(kJobColumns) + "FROM job WHERE state='running' ORDER BY id");
}

Result<JobCounts> JobQueue::Count() const {
  const auto db = db_.Read();
  return db->One(RowOf<JobCounts, int, int, int, int, int>, Error{},
                 "SELECT count(*) FILTER (WHERE state='accepted'), count(*) FILTER (WHERE state='running'),"
                 " count(*) FILTER (WHERE state='successful'), count(*) FILTER (WHERE state='failed'),"
                 " count(*) FILTER (WHERE state='dismissed') FROM job");
}

Result<int> JobQueue::CountUnfinished(int most) const {
  const auto db = db_.Read();
  SKYQUILT_TRY_ASSIGN(
      const std::int64_t unfinished,
      db->Number("SELECT (SELECT count(*) FROM (SELECT 1 FROM job WHERE state='running' LIMIT ?1) AS few)"
                 " + (SELECT count(*) FROM (SELECT 1 FROM job WHERE state='accepted' LIMIT ?1) AS few)",
                 most));
  return std::min(most, static_cast<int>(unfinished));
}

Result<Job> JobQueue::Cancel(const std::string& id, Time by_machine) {
  const auto db = db_.Lock();
  const Time now = db_.SharedTime(by_machine, *db);
  SKYQUILT_TRY(db->Change(std::string(kCancelJobs) + "id=?1", id, ToUs(now)));
  const bool changed = db->Changes() > 0;
  Result<Job> job = ReadJob(*db, id);
  if (job && !changed && job->state != JobState::kDismissed) {
    return Error{ErrorCode::kConflict, fmt::format("This job is {} already.", JobStateName(job->state)), ""};
  }
  return job;
}

Result<void> JobQueue::Remove(const std::string& id) {
  const auto db = db_.Lock();
  SKYQUILT_TRY(db->Change("DELETE FROM job WHERE id=? AND state NOT IN ('accepted','running')", id));
  if (db->Changes() == 0) return Error{ErrorCode::kConflict, "This job has not ended.", ""};
  return {};
}

Result<std::vector<JobQueue::LiveLease>> JobQueue::LiveLeases(Time by_machine) const {
  const auto db = db_.Read();
  const Time now = db_.SharedTime(by_machine, *db);
  const auto lease_from = [](const Statement& row) {
    Lease lease;
    row.Into(lease.flight_id, lease.job_id, lease.token);
    return LiveLease{lease.flight_id, WorkName(lease)};
  };
  return db->All(lease_from,
                 "SELECT flight_id, id, lease_token FROM job WHERE state='running' AND lease_until_us>=?",
                 ToUs(now));
}

Result<std::vector<std::string>> JobQueue::UnfinishedJobs() const {
  const auto db = db_.Read();
  return db->AllText("SELECT id FROM job WHERE state IN ('accepted', 'running')");
}

Result<bool> JobQueue::HasEnded(const std::string& id) const {
  const auto db = db_.Read();
  return db->Finds("SELECT 1 FROM job WHERE id=? AND finished_us IS NOT NULL", id);
}

Result<std::vector<std::string>> JobQueue::JobsOf(const std::string& flight_id) const {
  const auto db = db_.Read();
  return db->AllText("SELECT id FROM job WHERE flight_id=?", flight_id);
}

}  // namespace skyquilt::storage
