#include "storage/jobs/lost_leases.h"

#include <string>

#include "core/base/try.h"
#include "core/flight/remarks/because.h"
#include "storage/db/machine_boot.h"
#include "storage/jobs/job_rows.h"

namespace skyquilt::storage {
namespace {

// A machine's clock that was ahead and has been set back leaves leases and pauses that would last for days.
constexpr std::chrono::hours kAbsurdlyFar{1};

// Whose name begins with ?2.
constexpr const char* kOfServed = "substr(worker,1,length(?2))=?2";

}  // namespace

Result<void> SettleLostLeases(SqlConnection& db, Time now) {
  SKYQUILT_TRY_ASSIGN(
      Statement dismiss,
      db.Prepare(
          "UPDATE job SET state='dismissed', finished_us=?1 WHERE state='running' AND lease_until_us<?1 AND cancel=1"));
  SKYQUILT_TRY(dismiss.Bind(1, ToUs(now)).Run());
  // A server releases at once what a worker of its own held that died. Where such a lease runs out, the
  // server is gone as well.
  // Where many machines share the catalogue, a start of a machine that is none's present one has ended.
  const bool is_shared = db.dialect() == Dialect::kPostgres;
  SKYQUILT_TRY_ASSIGN(
      Statement interrupt,
      db.Prepare(std::string("UPDATE job SET") + kInterrupt +
                 "WHERE state='running' AND lease_until_us<?1 AND worker<>'units' AND (" +
                 (is_shared ? "claimed_in NOT IN (SELECT boot_id FROM machine)" : "claimed_in<>?3") + " OR " +
                 kOfServed + ")"));
  interrupt.Bind(1, ToUs(now)).Bind(2, kServedWorkerPrefix);
  if (!is_shared) interrupt.Bind(3, MachineBoot::Id());
  SKYQUILT_TRY(interrupt.Run());
  SKYQUILT_TRY_ASSIGN(
      Statement fail,
      db.Prepare(
          "UPDATE job SET state='failed', finished_us=?1, error_code=?2, error_message=?3, error_reason=?4"
          " WHERE state='running' AND lease_until_us<?1 AND attempts>=max_attempts"));
  const Error died = flight::Because(ErrorCode::kInternal, flight::RemarkCode::kFailWorkersDied);
  return fail.Bind(1, ToUs(now))
      .Bind(2, ErrorCodeName(died.code))
      .Bind(3, died.message)
      .Bind(4, ReasonText(died))
      .Run();
}

Result<int> JobQueue::ReleaseWorker(const std::string& worker, WorkerEnd end, Time by_machine) {
  const auto db = db_.Lock();
  const Time now = db_.SharedTime(by_machine, *db);
  SKYQUILT_TRY_ASSIGN(
      Statement update,
      db->Prepare(
          end == WorkerEnd::kDied
              ? std::string(
                    "UPDATE job SET lease_until_us=?1-1, worker='' WHERE state='running' AND worker=?2")
              : std::string("UPDATE job SET") + kInterrupt + "WHERE state='running' AND worker=?2"));
  SKYQUILT_TRY(update.Bind(1, ToUs(now)).Bind(2, worker).Run());
  return static_cast<int>(db->Changes());
}

Result<int> JobQueue::TakeUpAfterRestart(Time by_machine) {
  const auto db = db_.Lock();
  const Time now = db_.SharedTime(by_machine, *db);
  SKYQUILT_TRY_ASSIGN(Transaction transaction, Transaction::Begin(*db));
  int released = 0;
  {
    SKYQUILT_TRY_ASSIGN(Statement served, db->Prepare(std::string("UPDATE job SET") + kInterrupt +
                                                      "WHERE state='running' AND " + kOfServed));
    SKYQUILT_TRY(served.Bind(1, ToUs(now)).Bind(2, db_.served_prefix()).Run());
    released = static_cast<int>(db->Changes());
    // Workers of others may live and renew; of those that do not, nobody knows what ended them. Other servers
    // of a shared catalogue go on, and know.
    SKYQUILT_TRY_ASSIGN(
        Statement others,
        db->Prepare(
            db_.IsShared()
                ? "UPDATE job SET worker='', lease_until_us=?1-1 WHERE state='running' AND lease_until_us>?2 AND worker<>'units'"
                : "UPDATE job SET claimed_in='',"
                  " lease_until_us=CASE WHEN lease_until_us>?2 THEN ?1-1 ELSE lease_until_us END"
                  " WHERE state='running' AND worker<>'units'"));
    SKYQUILT_TRY(others.Bind(1, ToUs(now)).Bind(2, ToUs(now + kAbsurdlyFar)).Run());
    SKYQUILT_TRY_ASSIGN(
        Statement waiting,
        db->Prepare("UPDATE job SET not_before_us=0 WHERE state='accepted' AND not_before_us>?"));
    SKYQUILT_TRY(waiting.Bind(1, ToUs(now + kAbsurdlyFar)).Run());
  }
  SKYQUILT_TRY(transaction.Commit());
  return released;
}

}  // namespace skyquilt::storage
