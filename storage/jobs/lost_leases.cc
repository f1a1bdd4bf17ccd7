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

}  // namespace skyquilt::storage
