#include "storage/jobs/lost_leases.h"

#include <string>

#include "core/base/try.h"
#include "storage/db/machine_boot.h"

namespace skyquilt::storage {
namespace {

// A machine's clock that was ahead and has been set back leaves leases and pauses that would last for days.
constexpr std::chrono::hours kAbsurdlyFar{1};

}  // namespace

Result<void> SettleLostLeases(SqliteDb& db, Time now) {
  SKYQUILT_TRY_ASSIGN(
      Statement dismiss,
      db.Prepare(
          "UPDATE job SET state='dismissed', finished_us=?1 WHERE state='running' AND lease_until_us<?1 AND cancel=1"));
  SKYQUILT_TRY(dismiss.Bind(1, ToUs(now)).Run());
  // A server releases at once what a worker of its own held that died. Where such a lease runs out, the
  // server is gone as well.
  SKYQUILT_TRY_ASSIGN(
      Statement interrupt,
      db.Prepare(std::string("UPDATE job SET") + kInterrupt +
                 "WHERE state='running' AND lease_until_us<?1 AND (claimed_in<>?2 OR worker GLOB ?3)"));
  SKYQUILT_TRY(interrupt.Bind(1, ToUs(now))
                   .Bind(2, MachineBoot::Id())
                   .Bind(3, std::string(kServedWorkerPrefix) + "*")
                   .Run());
  SKYQUILT_TRY_ASSIGN(
      Statement fail,
      db.Prepare("UPDATE job SET state='failed', finished_us=?1, error_code='internal', error_message=?2"
                 " WHERE state='running' AND lease_until_us<?1 AND attempts>=max_attempts"));
  return fail.Bind(1, ToUs(now))
      .Bind(2,
            "The worker died on every attempt (it may have run out of memory). Try fewer or smaller photos.")
      .Run();
}

Result<int> JobQueue::ReleaseWorker(const std::string& worker, WorkerEnd end, Time now) {
  const auto db = db_.Lock();
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

Result<int> JobQueue::TakeUpAfterRestart(Time now) {
  const auto db = db_.Lock();
  SKYQUILT_TRY_ASSIGN(Transaction transaction, Transaction::Begin(*db));
  int released = 0;
  {
    SKYQUILT_TRY_ASSIGN(Statement served, db->Prepare(std::string("UPDATE job SET") + kInterrupt +
                                                      "WHERE state='running' AND worker GLOB ?2"));
    SKYQUILT_TRY(served.Bind(1, ToUs(now)).Bind(2, std::string(kServedWorkerPrefix) + "*").Run());
    released = static_cast<int>(db->Changes());
    // Workers of others may live and renew; of those that do not, nobody knows what ended them.
    SKYQUILT_TRY_ASSIGN(
        Statement others,
        db->Prepare(
            "UPDATE job SET claimed_in='', lease_until_us=CASE WHEN lease_until_us>?2 THEN ?1-1 ELSE lease_until_us END"
            " WHERE state='running'"));
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
