// The workers' half of JobQueue: claim, renew, end, publish. Every statement that writes names the lease's
// token.
#include "core/base/try.h"
#include "storage/db/machine_boot.h"
#include "storage/jobs/claim_in_postgres.h"
#include "storage/jobs/job_queue.h"
#include "storage/jobs/job_rows.h"
#include "storage/jobs/job_turns.h"
#include "storage/jobs/lost_leases.h"
#include "storage/jobs/patiently.h"

namespace skyquilt::storage {
namespace {

constexpr const char* kHeld = " WHERE id=? AND lease_token=? AND state='running'";

std::int64_t LeaseEnd(Time now) { return ToUs(now + kLeaseTime); }

Result<LeaseState> ReadLease(SqlConnection& db, const Lease& lease) {
  SKYQUILT_TRY_ASSIGN(Statement query, db.Prepare(std::string("SELECT cancel FROM job") + kHeld));
  SKYQUILT_TRY_ASSIGN(const bool row, query.Bind(1, lease.job_id).Bind(2, lease.token).Step());
  if (!row) return LeaseState::kLost;
  return query.ColumnInt64(0) != 0 ? LeaseState::kCancelRequested : LeaseState::kHeld;
}

// By this lease: said a second time, where nobody heard how the first ended.
Result<bool> IsPublished(SqlConnection& db, const Lease& lease, std::int64_t revision) {
  SKYQUILT_TRY_ASSIGN(
      Statement query,
      db.Prepare("SELECT 1 FROM job j JOIN revision r ON r.flight_id=j.flight_id AND r.revision=?3"
                 " WHERE j.id=?1 AND j.lease_token=?2 AND j.state='successful'"));
  return query.Bind(1, lease.job_id).Bind(2, lease.token).Bind(3, revision).Step();
}

}  // namespace

Result<std::optional<Lease>> JobQueue::Claim(std::string_view worker, Time by_machine) {
  return db_.Again([&]() -> Result<std::optional<Lease>> {
    const auto db = db_.Lock();
    const Time now = db_.SharedTime(by_machine, *db);
    if (db_.IsShared()) return ClaimInPostgres(*db, worker, now, db_.LostBefore(now));
    {
      // An idle worker only reads; the write lock is taken when there is something to take.
      SKYQUILT_TRY_ASSIGN(
          Statement look,
          db->Prepare("SELECT EXISTS(SELECT 1 FROM job WHERE state='accepted' AND not_before_us<=?1)"
                      " OR EXISTS(SELECT 1 FROM job WHERE state='running' AND lease_until_us<?1)"));
      SKYQUILT_TRY(look.Bind(1, ToUs(now)).Step());
      if (look.ColumnInt64(0) == 0) return std::optional<Lease>();
    }
    // A claim that a power cut undoes leaves the job waiting, as it should be: its worker is gone as well.
    SKYQUILT_TRY_ASSIGN(const UnsyncedCommits unsynced, UnsyncedCommits::Begin(*db));
    SKYQUILT_TRY_ASSIGN(Transaction transaction, Transaction::Begin(*db));
    SKYQUILT_TRY(SettleLostLeases(*db, now));
    std::optional<Lease> lease;
    {
      SKYQUILT_TRY_ASSIGN(const std::optional<std::string> next, NextJob(*db, now));
      if (!next) {
        SKYQUILT_TRY(transaction.Commit());
        return std::optional<Lease>();
      }
      SKYQUILT_TRY_ASSIGN(
          Statement claim,
          db->Prepare(
              "UPDATE job SET state='running', lease_token=lease_token+1, attempts=attempts+1, worker=?1,"
              " lease_until_us=?2, started_us=coalesce(started_us,?3), "
              " attempt_started_us=CASE worker WHEN 'units' THEN attempt_started_us ELSE ?3 END,"
              " stage=CASE worker WHEN 'units' THEN stage ELSE '' END,"
              " progress=CASE worker WHEN 'units' THEN progress ELSE 0 END, message='', claimed_in=?5 WHERE id=?4 RETURNING id, flight_id, options, lease_token, attempts"));
      claim.Bind(1, worker)
          .Bind(2, LeaseEnd(now))
          .Bind(3, ToUs(now))
          .Bind(4, *next)
          .Bind(5, MachineBoot::Id());
      SKYQUILT_TRY_ASSIGN(const bool row, claim.Step());
      if (row) {
        lease = Lease{std::string(claim.ColumnText(0)), std::string(claim.ColumnText(1)),
                      std::string(claim.ColumnText(2)), claim.ColumnInt64(3),
                      static_cast<int>(claim.ColumnInt64(4))};
      }
    }
    SKYQUILT_TRY(transaction.Commit());
    return lease;
  });
}

Result<LeaseState> JobQueue::Renew(const Lease& lease, Time by_machine) {
  const auto db = db_.Lock();
  const Time now = db_.SharedTime(by_machine, *db);
  SKYQUILT_TRY_ASSIGN(Statement update,
                      db->Prepare("UPDATE job SET lease_until_us=" + LeaseEndSql(*db, "?3") +
                                  ", claimed_in=?4 WHERE id=?1 AND lease_token=?2 AND state='running'"));
  SKYQUILT_TRY(update.Bind(1, lease.job_id)
                   .Bind(2, lease.token)
                   .Bind(3, LeaseEnd(now))
                   .Bind(4, MachineBoot::Id())
                   .Run());
  return ReadLease(*db, lease);
}

Result<LeaseState> JobQueue::LeaseStateOf(const Lease& lease) const {
  const auto db = db_.Read();
  return ReadLease(*db, lease);
}

Result<LeaseState> JobQueue::Expect(const Lease& lease, const Expectation& expectation) {
  const auto db = db_.Lock();
  SKYQUILT_TRY_ASSIGN(Statement update,
                      db->Prepare("UPDATE job SET expected_s=?3, expected_low_s=?4, expected_high_s=?5"
                                  " WHERE id=?1 AND lease_token=?2 AND state='running'"));
  SKYQUILT_TRY(update.Bind(1, lease.job_id)
                   .Bind(2, lease.token)
                   .Bind(3, expectation.total_s)
                   .Bind(4, expectation.low_s)
                   .Bind(5, expectation.high_s)
                   .Run());
  return ReadLease(*db, lease);
}

Result<LeaseState> JobQueue::ReportProgress(const Lease& lease, const JobProgress& progress) {
  const auto db = db_.Lock();
  SKYQUILT_TRY_ASSIGN(
      Statement update,
      db->Prepare(
          "UPDATE job SET stage=?3, progress=?4, message=?5 WHERE id=?1 AND lease_token=?2 AND state='running'"));
  SKYQUILT_TRY(update.Bind(1, lease.job_id)
                   .Bind(2, lease.token)
                   .Bind(3, progress.stage)
                   .Bind(4, progress.fraction)
                   .Bind(5, progress.message)
                   .Run());
  return ReadLease(*db, lease);
}

Result<bool> JobQueue::Fail(const Lease& lease, const Error& error, bool may_retry, Time by_machine) {
  const auto db = db_.Lock();
  const Time now = db_.SharedTime(by_machine, *db);
  Result<Statement> update = db->Prepare(
      "UPDATE job SET"
      " state=CASE WHEN cancel=1 THEN 'dismissed' WHEN ?3=1 AND attempts<max_attempts THEN 'accepted' ELSE 'failed' END,"
      " finished_us=CASE WHEN ?3=1 AND attempts<max_attempts AND cancel=0 THEN NULL ELSE ?4 END,"
      " not_before_us=?4+attempts*2000000, error_code=CASE cancel WHEN 1 THEN NULL ELSE ?5 END,"
      " error_message=CASE cancel WHEN 1 THEN NULL ELSE ?6 END,"
      " error_reason=CASE cancel WHEN 1 THEN '' ELSE ?7 END"
      " WHERE id=?1 AND lease_token=?2 AND state='running'");
  if (!update) return update.error();
  const Result<void> done = update->Bind(1, lease.job_id)
                                .Bind(2, lease.token)
                                .Bind(3, may_retry ? 1 : 0)
                                .Bind(4, ToUs(now))
                                .Bind(5, ErrorCodeName(error.code))
                                .Bind(6, error.message)
                                .Bind(7, ReasonText(error))
                                .Run();
  if (!done) return done.error();
  return db->Changes() > 0;
}

Result<bool> JobQueue::Dismiss(const Lease& lease, Time by_machine) {
  const auto db = db_.Lock();
  const Time now = db_.SharedTime(by_machine, *db);
  SKYQUILT_TRY_ASSIGN(
      Statement update,
      db->Prepare(
          "UPDATE job SET state='dismissed', finished_us=?3 WHERE id=?1 AND lease_token=?2 AND state='running'"));
  SKYQUILT_TRY(update.Bind(1, lease.job_id).Bind(2, lease.token).Bind(3, ToUs(now)).Run());
  return db->Changes() > 0;
}

Result<bool> JobQueue::GiveBack(const Lease& lease, Time by_machine) {
  const auto db = db_.Lock();
  const Time now = db_.SharedTime(by_machine, *db);
  SKYQUILT_TRY_ASSIGN(
      Statement update,
      db->Prepare(
          "UPDATE job SET state=CASE cancel WHEN 1 THEN 'dismissed' ELSE 'accepted' END,"
          " finished_us=CASE cancel WHEN 1 THEN ?3 ELSE NULL END, attempts=attempts-1, not_before_us=0"
          " WHERE id=?1 AND lease_token=?2 AND state='running'"));
  SKYQUILT_TRY(update.Bind(1, lease.job_id).Bind(2, lease.token).Bind(3, ToUs(now)).Run());
  return db->Changes() > 0;
}

Result<int> JobQueue::CountTrouble(const Lease& lease) {
  const auto db = db_.Lock();
  SKYQUILT_TRY_ASSIGN(Statement count, db->Prepare(std::string("UPDATE job SET troubles=troubles+1") + kHeld +
                                                   " RETURNING troubles"));
  return NumberFrom(count.Bind(1, lease.job_id).Bind(2, lease.token));
}

Result<std::optional<std::int64_t>> JobQueue::ReserveRevision(const Lease& lease) {
  return Patiently(db_, [&] { return ReserveOnce(lease); });  // a number that nobody hears of is left out
}

Result<std::optional<std::int64_t>> JobQueue::ReserveOnce(const Lease& lease) {
  const auto db = db_.Lock();
  SKYQUILT_TRY_ASSIGN(
      Statement update,
      db->Prepare(
          "UPDATE flight SET next_revision=next_revision+1 WHERE id=?3 AND EXISTS("
          " SELECT 1 FROM job WHERE id=?1 AND lease_token=?2 AND state='running') RETURNING next_revision-1"));
  SKYQUILT_TRY_ASSIGN(const bool row,
                      update.Bind(1, lease.job_id).Bind(2, lease.token).Bind(3, lease.flight_id).Step());
  if (!row) return std::optional<std::int64_t>();
  const std::int64_t revision = update.ColumnInt64(0);
  // RETURNING hands out its row before the statement is done; only done is committed.
  SKYQUILT_TRY(update.Step());
  return std::optional<std::int64_t>(revision);
}

Result<bool> JobQueue::Publish(const Lease& lease, const Revision& revision, Time now,
                               const std::vector<MapProduct>& products) {
  return Patiently(db_, [&] { return PublishOnce(lease, revision, now, products); });
}

Result<bool> JobQueue::PublishOnce(const Lease& lease, const Revision& revision, Time by_machine,
                                   const std::vector<MapProduct>& products) {
  return db_.Again([&]() -> Result<bool> {
    const auto db = db_.Lock();
    const Time now = db_.SharedTime(by_machine, *db);
    SKYQUILT_TRY_ASSIGN(Transaction transaction, Transaction::Begin(*db, lease.flight_id));
    {
      SKYQUILT_TRY_ASSIGN(
          Statement end,
          db->Prepare(
              "UPDATE job SET state='successful', progress=1, stage='done', message='', finished_us=?3, "
              "error_code=NULL,"
              " error_message=NULL, error_reason='' WHERE id=?1 AND lease_token=?2 AND state='running'"
              " AND cancel=0"));
      SKYQUILT_TRY(end.Bind(1, lease.job_id).Bind(2, lease.token).Bind(3, ToUs(now)).Run());
      if (db->Changes() == 0) return IsPublished(*db, lease, revision.revision);
      SKYQUILT_TRY_ASSIGN(Statement insert,
                          db->Prepare("INSERT INTO revision VALUES(?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?)"));
      insert.Bind(1, lease.flight_id).Bind(2, revision.revision).Bind(3, ToUs(now));
      insert.Bind(4, revision.bounds.west_deg).Bind(5, revision.bounds.south_deg);
      insert.Bind(6, revision.bounds.east_deg).Bind(7, revision.bounds.north_deg);
      insert.Bind(8, revision.min_zoom).Bind(9, revision.max_zoom).Bind(10, revision.gsd_m);
      insert.Bind(11, revision.photos_total).Bind(12, revision.photos_aligned);
      insert.Bind(13, revision.photos_pose_only).Bind(14, revision.photos_left_out);
      insert.Bind(15, revision.first_capture).Bind(16, revision.last_capture).Bind(17, revision.quality);
      SKYQUILT_TRY(insert.Run());
      SKYQUILT_TRY(EnterProducts(*db, lease.flight_id, revision.revision, products));
      // The one shown until now stays readable for whoever looked it up a moment ago; older ones go.
      SKYQUILT_TRY_ASSIGN(
          Statement forget,
          db->Prepare("DELETE FROM revision WHERE flight_id=?1 AND revision<>?2 AND"
                      " revision IS DISTINCT FROM (SELECT active_revision FROM flight WHERE id=?1)"));
      SKYQUILT_TRY(forget.Bind(1, lease.flight_id).Bind(2, revision.revision).Run());
      SKYQUILT_TRY_ASSIGN(Statement end_preview, db->Prepare("DELETE FROM preview WHERE flight_id=?"));
      SKYQUILT_TRY(end_preview.Bind(1, lease.flight_id).Run());
      SKYQUILT_TRY_ASSIGN(Statement activate,
                          db->Prepare("UPDATE flight SET active_revision=?2 WHERE id=?1"));
      SKYQUILT_TRY(activate.Bind(1, lease.flight_id).Bind(2, revision.revision).Run());
    }
    SKYQUILT_TRY(transaction.Commit());
    return true;
  });
}

}  // namespace skyquilt::storage
