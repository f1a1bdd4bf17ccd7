#include "storage/jobs/job_leases.h"

#include <string>

#include "core/base/try.h"
#include "core/flight/remarks/because.h"
#include "storage/db/machine_boot.h"
#include "storage/jobs/job_rows.h"
#include "storage/jobs/job_turns.h"

namespace skyquilt::storage {
namespace {

// A machine's clock that was ahead and has been set back leaves leases and pauses that would last for days.
constexpr std::chrono::hours kAbsurdlyFar{1};

// A claim was cut off from outside: the attempt does not count, the interruption does; of kMaxInterruptions
// the last ends the job. Goes between "UPDATE job SET" and "WHERE state='running'"; parameter ?1 is the time.
constexpr const char* kInterrupt =
    " attempts=attempts-1, interruptions=interruptions+1, not_before_us=0, worker='',"
    " state=CASE WHEN cancel=1 THEN 'dismissed' WHEN interruptions+1>=10 THEN 'failed' ELSE 'accepted' END,"
    " finished_us=CASE WHEN cancel=1 OR interruptions+1>=10 THEN ?1 ELSE NULL END,"
    " error_code=CASE WHEN interruptions+1>=10 THEN 'unavailable' ELSE error_code END,"
    " error_message=CASE WHEN interruptions+1>=10 THEN 'This job was interrupted 10 times by restarts of the server or the"
    " machine, and is not begun again by itself. If it was the job that brought the machine down, try fewer or smaller"
    " photos; if not, start it again.' ELSE error_message END ";
static_assert(kMaxInterruptions == 10, "the statement above names it");

// Whose name begins with ?2.
constexpr const char* kOfServed = "substr(worker,1,length(?2))=?2";

}  // namespace

Result<void> SettleLostLeases(SqlConnection& db, Time now) {
  SKYQUILT_TRY(db.Change(
      "UPDATE job SET state='dismissed', finished_us=?1 WHERE state='running' AND lease_until_us<?1 AND cancel=1",
      ToUs(now)));
  // A server releases at once what a worker of its own held that died. Where such a lease runs out, the
  // server is gone as well.
  // Where many machines share the catalogue, a start of a machine that is none's present one has ended.
  const bool is_shared = db.dialect() == Dialect::kPostgres;
  SKYQUILT_TRY_ASSIGN(
      Statement interrupt,
      db.Query(std::string("UPDATE job SET") + kInterrupt +
                   "WHERE state='running' AND lease_until_us<?1 AND worker<>'units' AND (" +
                   (is_shared ? "claimed_in NOT IN (SELECT boot_id FROM machine)" : "claimed_in<>?3") +
                   " OR " + kOfServed + ")",
               ToUs(now), kServedWorkerPrefix));
  if (!is_shared) interrupt.Bind(3, MachineBoot::Id());
  SKYQUILT_TRY(interrupt.Run());
  const Error died = flight::Because(ErrorCode::kInternal, flight::RemarkCode::kFailWorkersDied);
  return db.Change(
      "UPDATE job SET state='failed', finished_us=?1, error_code=?2, error_message=?3, error_reason=?4"
      " WHERE state='running' AND lease_until_us<?1 AND attempts>=max_attempts",
      ToUs(now), ErrorCodeName(died.code), died.message, ReasonText(died));
}

Result<int> JobQueue::ReleaseWorker(const std::string& worker, WorkerEnd end, Time by_machine) {
  const auto db = db_.Lock();
  const Time now = db_.SharedTime(by_machine, *db);
  SKYQUILT_TRY(db->Change(std::string("UPDATE job SET") +
                              (end == WorkerEnd::kDied ? " lease_until_us=?1-1, worker='' " : kInterrupt) +
                              "WHERE state='running' AND worker=?2",
                          ToUs(now), worker));
  return static_cast<int>(db->Changes());
}

Result<int> JobQueue::TakeUpAfterRestart(Time by_machine) {
  const auto db = db_.Lock();
  const Time now = db_.SharedTime(by_machine, *db);
  SKYQUILT_TRY_ASSIGN(Transaction transaction, Transaction::Begin(*db));
  SKYQUILT_TRY(
      db->Change(std::string("UPDATE job SET") + kInterrupt + "WHERE state='running' AND " + kOfServed,
                 ToUs(now), db_.served_prefix()));
  const int released = static_cast<int>(db->Changes());
  // Workers of others may live and renew; of those that do not, nobody knows what ended them. Other servers
  // of a shared catalogue go on, and know.
  SKYQUILT_TRY(db->Change(
      db_.IsShared()
          ? "UPDATE job SET worker='', lease_until_us=?1-1 WHERE state='running' AND lease_until_us>?2 AND worker<>'units'"
          : "UPDATE job SET claimed_in='',"
            " lease_until_us=CASE WHEN lease_until_us>?2 THEN ?1-1 ELSE lease_until_us END"
            " WHERE state='running' AND worker<>'units'",
      ToUs(now), ToUs(now + kAbsurdlyFar)));
  SKYQUILT_TRY(db->Change("UPDATE job SET not_before_us=0 WHERE state='accepted' AND not_before_us>?",
                          ToUs(now + kAbsurdlyFar)));
  SKYQUILT_TRY(transaction.Commit());
  return released;
}

// Every statement of the holder that writes names the lease's token.
namespace {

constexpr const char* kHeld = " WHERE id=?1 AND lease_token=?2 AND state='running'";

std::int64_t LeaseEnd(Time now) { return ToUs(now + kLeaseTime); }

Result<LeaseState> ReadLease(SqlConnection& db, const Lease& lease) {
  SKYQUILT_TRY_ASSIGN(Statement query,
                      db.Query(std::string("SELECT cancel FROM job") + kHeld, lease.job_id, lease.token));
  return LeaseStateFrom(query);
}

// What is to be set of the leased job; `values` are ?3 and on. False: the lease was lost.
template <typename... Values>
Result<bool> ChangeHeldJob(SqlConnection& db, const Lease& lease, const std::string& set,
                           const Values&... values) {
  SKYQUILT_TRY(db.Change("UPDATE job SET " + set + kHeld, lease.job_id, lease.token, values...));
  return db.Changes() > 0;
}

// By this lease: said a second time, where nobody heard how the first ended.
Result<bool> IsPublished(SqlConnection& db, const Lease& lease, std::int64_t revision) {
  return db.Finds(
      "SELECT 1 FROM job j JOIN revision r ON r.flight_id=j.flight_id AND r.revision=?3"
      " WHERE j.id=?1 AND j.lease_token=?2 AND j.state='successful'",
      lease.job_id, lease.token, revision);
}

}  // namespace

Result<std::optional<Lease>> JobQueue::Claim(std::string_view worker, Time by_machine) {
  return db_.Again([&]() -> Result<std::optional<Lease>> {
    const auto db = db_.Lock();
    const Time now = db_.SharedTime(by_machine, *db);
    return db_.IsShared() ? ClaimInPostgres(*db, worker, now, db_.LostBefore(now))
                          : ClaimInFolder(*db, worker, now);
  });
}

Result<LeaseState> JobQueue::Renew(const Lease& lease, Time by_machine) {
  const auto db = db_.Lock();
  const Time now = db_.SharedTime(by_machine, *db);
  SKYQUILT_TRY(ChangeHeldJob(*db, lease, "lease_until_us=" + LeaseEndSql(*db, "?3") + ", claimed_in=?4",
                             LeaseEnd(now), MachineBoot::Id()));
  return ReadLease(*db, lease);
}

Result<LeaseState> JobQueue::LeaseStateOf(const Lease& lease) const {
  const auto db = db_.Read();
  return ReadLease(*db, lease);
}

Result<LeaseState> JobQueue::Expect(const Lease& lease, const Expectation& expectation) {
  const auto db = db_.Lock();
  SKYQUILT_TRY(ChangeHeldJob(*db, lease, "expected_s=?3, expected_low_s=?4, expected_high_s=?5",
                             expectation.total_s, expectation.low_s, expectation.high_s));
  return ReadLease(*db, lease);
}

Result<LeaseState> JobQueue::ReportProgress(const Lease& lease, const JobProgress& progress) {
  const auto db = db_.Lock();
  SKYQUILT_TRY(ChangeHeldJob(*db, lease, "stage=?3, progress=?4, message=?5", progress.stage,
                             progress.fraction, progress.message));
  return ReadLease(*db, lease);
}

Result<bool> JobQueue::Fail(const Lease& lease, const Error& error, bool may_retry, Time by_machine) {
  const auto db = db_.Lock();
  const Time now = db_.SharedTime(by_machine, *db);
  return ChangeHeldJob(
      *db, lease,
      "state=CASE WHEN cancel=1 THEN 'dismissed' WHEN ?3=1 AND attempts<max_attempts THEN 'accepted' ELSE 'failed' END,"
      " finished_us=CASE WHEN ?3=1 AND attempts<max_attempts AND cancel=0 THEN NULL ELSE ?4 END,"
      " not_before_us=?4+attempts*2000000, error_code=CASE cancel WHEN 1 THEN NULL ELSE ?5 END,"
      " error_message=CASE cancel WHEN 1 THEN NULL ELSE ?6 END,"
      " error_reason=CASE cancel WHEN 1 THEN '' ELSE ?7 END",
      may_retry ? 1 : 0, ToUs(now), ErrorCodeName(error.code), error.message, ReasonText(error));
}

Result<bool> JobQueue::Dismiss(const Lease& lease, Time by_machine) {
  const auto db = db_.Lock();
  const Time now = db_.SharedTime(by_machine, *db);
  return ChangeHeldJob(*db, lease, "state='dismissed', finished_us=?3", ToUs(now));
}

Result<bool> JobQueue::GiveBack(const Lease& lease, Time by_machine) {
  const auto db = db_.Lock();
  const Time now = db_.SharedTime(by_machine, *db);
  return ChangeHeldJob(
      *db, lease,
      "state=CASE cancel WHEN 1 THEN 'dismissed' ELSE 'accepted' END,"
      " finished_us=CASE cancel WHEN 1 THEN ?3 ELSE NULL END, attempts=attempts-1, not_before_us=0",
      ToUs(now));
}

Result<int> JobQueue::CountTrouble(const Lease& lease) {
  const auto db = db_.Lock();
  SKYQUILT_TRY_ASSIGN(
      const std::int64_t troubles,
      db->Number(std::string("UPDATE job SET troubles=troubles+1") + kHeld + " RETURNING troubles",
                 lease.job_id, lease.token));
  return static_cast<int>(troubles);
}

Result<std::optional<std::int64_t>> JobQueue::ReserveRevision(const Lease& lease) {
  // A number that nobody hears of is left out.
  return db_.Patiently([&]() -> Result<std::optional<std::int64_t>> {
    const auto db = db_.Lock();
    return db->First(
        FirstColumn<std::int64_t>,
        "UPDATE flight SET next_revision=next_revision+1 WHERE id=?3 AND EXISTS("
        " SELECT 1 FROM job WHERE id=?1 AND lease_token=?2 AND state='running') RETURNING next_revision-1",
        lease.job_id, lease.token, lease.flight_id);
  });
}

Result<bool> JobQueue::Publish(const Lease& lease, const Revision& revision, Time by_machine,
                               const std::vector<MapProduct>& products) {
  const auto publish = [&]() -> Result<bool> {
    const auto db = db_.Lock();
    const Time now = db_.SharedTime(by_machine, *db);
    SKYQUILT_TRY_ASSIGN(Transaction transaction, Transaction::Begin(*db, lease.flight_id));
    SKYQUILT_TRY(db->Change(
        std::string("UPDATE job SET state='successful', progress=1, stage='done', message='', finished_us=?3,"
                    " error_code=NULL, error_message=NULL, error_reason=''") +
            kHeld + " AND cancel=0",
        lease.job_id, lease.token, ToUs(now)));
    if (db->Changes() == 0) return IsPublished(*db, lease, revision.revision);
    // The one shown until now stays readable for whoever looked it up a moment ago; older ones go.
    SKYQUILT_TRY(
        db->Change("DELETE FROM revision WHERE flight_id=?1 AND revision<>?2 AND"
                   " revision IS DISTINCT FROM (SELECT active_revision FROM flight WHERE id=?1)",
                   lease.flight_id, revision.revision));
    SKYQUILT_TRY(ShowRevision(*db, lease.flight_id, revision, now));
    SKYQUILT_TRY(EnterProducts(*db, lease.flight_id, revision.revision, products));
    SKYQUILT_TRY(transaction.Commit());
    return true;
  };
  return db_.Patiently([&] { return db_.Again(publish); });
}

}  // namespace skyquilt::storage
