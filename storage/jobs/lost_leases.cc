#include "storage/jobs/lost_leases.h"

#include <string>

#include "storage/db/machine_boot.h"

namespace skyquilt::storage {
namespace {

// A machine's clock that was ahead and has been set back leaves leases and pauses that would last for days.
constexpr std::chrono::hours kAbsurdlyFar{1};

}  // namespace

Result<void> SettleLostLeases(SqliteDb& db, Time now) {
  Result<Statement> dismiss = db.Prepare(
      "UPDATE job SET state='dismissed', finished_us=?1 WHERE state='running' AND lease_until_us<?1 AND cancel=1");
  if (!dismiss) return dismiss.error();
  const Result<void> dismissed = dismiss->Bind(1, ToUs(now)).Run();
  if (!dismissed) return dismissed.error();
  // A server releases at once what a worker of its own held that died. Where such a lease runs out, the
  // server is gone as well.
  Result<Statement> interrupt =
      db.Prepare(std::string("UPDATE job SET") + kInterrupt +
                 "WHERE state='running' AND lease_until_us<?1 AND (claimed_in<>?2 OR worker GLOB ?3)");
  if (!interrupt) return interrupt.error();
  const Result<void> interrupted = interrupt->Bind(1, ToUs(now))
                                       .Bind(2, MachineBoot::Id())
                                       .Bind(3, std::string(kServedWorkerPrefix) + "*")
                                       .Run();
  if (!interrupted) return interrupted.error();
  Result<Statement> fail = db.Prepare(
      "UPDATE job SET state='failed', finished_us=?1, error_code='internal', error_message=?2"
      " WHERE state='running' AND lease_until_us<?1 AND attempts>=max_attempts");
  if (!fail) return fail.error();
  return fail->Bind(1, ToUs(now))
      .Bind(2,
            "The worker died on every attempt (it may have run out of memory). Try fewer or smaller photos.")
      .Run();
}

Result<int> JobQueue::ReleaseWorker(const std::string& worker, WorkerEnd end, Time now) {
  const auto db = db_.Lock();
  Result<Statement> update = db->Prepare(
      end == WorkerEnd::kDied
          ? std::string("UPDATE job SET lease_until_us=?1-1, worker='' WHERE state='running' AND worker=?2")
          : std::string("UPDATE job SET") + kInterrupt + "WHERE state='running' AND worker=?2");
  if (!update) return update.error();
  const Result<void> done = update->Bind(1, ToUs(now)).Bind(2, worker).Run();
  if (!done) return done.error();
  return static_cast<int>(db->Changes());
}

Result<int> JobQueue::TakeUpAfterRestart(Time now) {
  const auto db = db_.Lock();
  Result<Transaction> transaction = Transaction::Begin(*db);
  if (!transaction) return transaction.error();
  int released = 0;
  {
    Result<Statement> served =
        db->Prepare(std::string("UPDATE job SET") + kInterrupt + "WHERE state='running' AND worker GLOB ?2");
    if (!served) return served.error();
    const Result<void> done =
        served->Bind(1, ToUs(now)).Bind(2, std::string(kServedWorkerPrefix) + "*").Run();
    if (!done) return done.error();
    released = static_cast<int>(db->Changes());
    // Workers of others may live and renew; of those that do not, nobody knows what ended them.
    Result<Statement> others = db->Prepare(
        "UPDATE job SET claimed_in='', lease_until_us=CASE WHEN lease_until_us>?2 THEN ?1-1 ELSE lease_until_us END"
        " WHERE state='running'");
    if (!others) return others.error();
    const Result<void> marked = others->Bind(1, ToUs(now)).Bind(2, ToUs(now + kAbsurdlyFar)).Run();
    if (!marked) return marked.error();
    Result<Statement> waiting =
        db->Prepare("UPDATE job SET not_before_us=0 WHERE state='accepted' AND not_before_us>?");
    if (!waiting) return waiting.error();
    const Result<void> due = waiting->Bind(1, ToUs(now + kAbsurdlyFar)).Run();
    if (!due) return due.error();
  }
  const Result<void> committed = transaction->Commit();
  if (!committed) return committed.error();
  return released;
}

}  // namespace skyquilt::storage
