#include "storage/jobs/unit_queue.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/base/try.h"
#include "core/flight/remarks/because.h"
#include "storage/db/machine_boot.h"
#include "storage/jobs/claim_in_postgres.h"
#include "storage/jobs/job_rows.h"
#include "storage/jobs/patiently.h"

namespace skyquilt::storage {
namespace {

constexpr const char* kHeldUnit =
    " WHERE job_id=?1 AND kind=?2 AND number=?3 AND lease_token=?4 AND state='running'";

Statement& BindUnit(Statement& statement, const UnitLease& unit) {
  return statement.Bind(1, unit.job_id).Bind(2, unit.kind).Bind(3, unit.number).Bind(4, unit.token);
}

Result<void> FailJobOf(SqlConnection& db, const std::string& job_id, const Error& error, Time now) {
  SKYQUILT_TRY_ASSIGN(
      Statement fail,
      db.Prepare("UPDATE job SET state=CASE cancel WHEN 1 THEN 'dismissed' ELSE 'failed' END,"
                 " finished_us=?2, worker='', error_code=CASE cancel WHEN 1 THEN NULL ELSE ?3 END,"
                 " error_message=CASE cancel WHEN 1 THEN NULL ELSE ?4 END,"
                 " error_reason=CASE cancel WHEN 1 THEN '' ELSE ?5 END"
                 " WHERE id=?1 AND state='running'"));
  return fail.Bind(1, job_id)
      .Bind(2, ToUs(now))
      .Bind(3, ErrorCodeName(error.code))
      .Bind(4, error.message)
      .Bind(5, ReasonText(error))
      .Run();
}

// Rows that another claim is taking are left to it.
const char* PassOverLocked(const SqlConnection& db) {
  return db.dialect() == Dialect::kPostgres ? " FOR UPDATE OF u SKIP LOCKED" : "";
}

// Units whose workers died again and again end their jobs.
Result<void> FailExhausted(SqlConnection& db, Time now) {
  std::vector<std::string> jobs;
  {
    SKYQUILT_TRY_ASSIGN(
        Statement query,
        db.Prepare(
            "SELECT DISTINCT job_id FROM unit WHERE state='running' AND lease_until_us<?1 AND attempts>=?2"));
    SKYQUILT_TRY_ASSIGN(jobs, query.Bind(1, ToUs(now)).Bind(2, kMaxUnitAttempts).AllText());
  }
  for (const std::string& job : jobs) {
    SKYQUILT_TRY(FailJobOf(
        db, job, flight::Because(ErrorCode::kInternal, flight::RemarkCode::kFailPartWorkersDied), now));
  }
  return {};
}

// There is something to claim: workers that sleep are told, at the end of the transaction.
Result<void> WakeWorkers(SqlConnection& db) {
  if (db.dialect() != Dialect::kPostgres) return {};
  return db.Exec("SELECT pg_notify(current_schema() || '.jobs', '')");
}

// Shown while units are at work, and given to a worker once all are done.
Result<void> GoOn(SqlConnection& db, const std::string& job_id, std::string_view kind) {
  SKYQUILT_TRY_ASSIGN(
      Statement query,
      db.Prepare(
          "SELECT count(*), count(*) FILTER (WHERE state='done') FROM unit WHERE job_id=?1 AND kind=?2"));
  SKYQUILT_TRY(query.Bind(1, job_id).Bind(2, kind).Step());
  const std::int64_t count = query.ColumnInt64(0), done = query.ColumnInt64(1);
  query.Reset();
  if (done == count) SKYQUILT_TRY(WakeWorkers(db));
  SKYQUILT_TRY_ASSIGN(
      Statement tell,
      db.Prepare("UPDATE job SET progress=units_from+(units_to-units_from)*?2, message=?3,"
                 " lease_until_us=CASE WHEN ?4=1 THEN 0 ELSE lease_until_us END, claimed_in=?5"
                 " WHERE id=?1 AND state='running' AND worker='units'"));
  return tell.Bind(1, job_id)
      .Bind(2, count > 0 ? static_cast<double>(done) / static_cast<double>(count) : 1.0)
      .Bind(3, fmt::format("part {} of {} is done", done, count))
      .Bind(4, done == count ? 1 : 0)
      .Bind(5, MachineBoot::Id())
      .Run();
}

}  // namespace

Result<bool> UnitQueue::Cut(const Lease& lease, std::string_view kind, int count, std::int64_t items,
                            const UnitProgress& progress, const std::set<int>& done) {
  return Patiently(db_, [&] { return CutOnce(lease, kind, count, items, progress, done); });
}

Result<bool> UnitQueue::CutOnce(const Lease& lease, std::string_view kind, int count, std::int64_t items,
                                const UnitProgress& progress, const std::set<int>& done) {
  return db_.Again([&]() -> Result<bool> {
    const auto db = db_.Lock();
    SKYQUILT_TRY_ASSIGN(Transaction transaction, Transaction::Begin(*db));
    {
      SKYQUILT_TRY_ASSIGN(
          Statement park,
          db->Prepare("UPDATE job SET worker='units', lease_until_us=?3, lease_token=lease_token+1,"
                      " attempts=attempts-1, stage=?4, units_from=?5, units_to=?6,"
                      " units_of=CASE units_of WHEN '' THEN id ELSE units_of END"
                      " WHERE id=?1 AND lease_token=?2 AND state='running'"));
      SKYQUILT_TRY(park.Bind(1, lease.job_id)
                       .Bind(2, lease.token)
                       .Bind(3, kUnitsLeaseUs)
                       .Bind(4, progress.stage)
                       .Bind(5, progress.from)
                       .Bind(6, progress.to)
                       .Run());
      if (db->Changes() == 0) return false;
      // Somebody wished to cancel it while its worker was here: nobody would see that now.
      SKYQUILT_TRY_ASSIGN(Statement dismiss,
                          db->Prepare("UPDATE job SET state='dismissed', worker='', finished_us=?2"
                                      " WHERE id=?1 AND state='running' AND cancel=1"));
      const std::int64_t now_us = ToUs(db_.SharedTime(Now(), *db));
      SKYQUILT_TRY(dismiss.Bind(1, lease.job_id).Bind(2, now_us).Run());
      const bool is_dismissed = db->Changes() > 0;
      SKYQUILT_TRY_ASSIGN(Statement add,
                          db->Prepare("INSERT INTO unit(job_id,kind,number,items,state,waiting_us)"
                                      " VALUES(?1,?2,?3,?4,?6,?5) ON CONFLICT DO NOTHING"));
      for (int number = 0; number < count && !is_dismissed; ++number) {
        SKYQUILT_TRY(add.Bind(1, lease.job_id)
                         .Bind(2, kind)
                         .Bind(3, number)
                         .Bind(4, items)
                         .Bind(5, now_us)
                         .Bind(6, done.contains(number) ? "done" : "waiting")
                         .Run());
      }
      SKYQUILT_TRY(GoOn(*db, lease.job_id, kind));
    }
    SKYQUILT_TRY(transaction.Commit());
    return true;
  });
}

Result<std::vector<UnitCount>> UnitQueue::Of(const std::string& job_id) const {
  const auto db = db_.Read();
  SKYQUILT_TRY_ASSIGN(Statement query,
                      db->Prepare("SELECT kind, count(*), count(*) FILTER (WHERE state='done'), max(items)"
                                  " FROM unit WHERE job_id=? GROUP BY kind ORDER BY kind"));
  query.Bind(1, job_id);
  std::vector<UnitCount> counts;
  while (true) {
    SKYQUILT_TRY_ASSIGN(const bool row, query.Step());
    if (!row) return counts;
    counts.push_back({std::string(query.ColumnText(0)), static_cast<int>(query.ColumnInt64(1)),
                      static_cast<int>(query.ColumnInt64(2)), query.ColumnInt64(3)});
  }
}

Result<std::vector<UnitsOfKind>> UnitQueue::Count(Time by_machine) const {
  const auto db = db_.Read();
  const Time now = db_.SharedTime(by_machine, *db);
  SKYQUILT_TRY_ASSIGN(
      Statement query,
      db->Prepare("WITH seen AS (SELECT kind, attempts,"
                  " CASE WHEN state='running' AND lease_until_us<?1 THEN 'waiting' ELSE state END AS state,"
                  " CASE WHEN state='running' AND lease_until_us>waiting_us THEN lease_until_us"
                  " ELSE waiting_us END AS since_us FROM unit)"
                  " SELECT kind, count(*) FILTER (WHERE state='waiting'),"
                  " count(*) FILTER (WHERE state='running'), count(*) FILTER (WHERE state='done'),"
                  " sum(CASE state WHEN 'waiting' THEN attempts ELSE attempts-1 END),"
                  " min(CASE state WHEN 'waiting' THEN since_us END) FROM seen GROUP BY kind ORDER BY kind"));
  query.Bind(1, ToUs(now));
  std::vector<UnitsOfKind> kinds;
  while (true) {
    SKYQUILT_TRY_ASSIGN(const bool row, query.Step());
    if (!row) return kinds;
    const auto column = [&](int i) { return static_cast<int>(query.ColumnInt64(i)); };
    UnitsOfKind kind{std::string(query.ColumnText(0)), column(1), column(2), column(3), column(4)};
    if (kind.waiting > 0)
      kind.longest_waiting_s = std::max(0.0, static_cast<double>(ToUs(now) - query.ColumnInt64(5)) * 1e-6);
    kinds.push_back(std::move(kind));
  }
}

Result<std::optional<UnitLease>> UnitQueue::Claim(std::string_view worker, Time by_machine) {
  return db_.Again([&]() -> Result<std::optional<UnitLease>> {
    {
      // As with jobs, an idle worker only reads.
      const auto db = db_.Read();
      const Time now = db_.SharedTime(by_machine, *db);
      SKYQUILT_TRY_ASSIGN(Statement look,
                          db->Prepare("SELECT CASE WHEN EXISTS(SELECT 1 FROM unit WHERE state='waiting'"
                                      " OR (state='running' AND lease_until_us<?1)) THEN 1 ELSE 0 END"));
      SKYQUILT_TRY(look.Bind(1, ToUs(db_.LostBefore(now))).Step());
      if (look.ColumnInt64(0) == 0) return std::optional<UnitLease>();
    }
    const auto db = db_.Lock();
    const Time now = db_.SharedTime(by_machine, *db);
    if (db_.IsShared()) SKYQUILT_TRY(GiveTimeAfterStart(*db, now));
    const Time lost_before = db_.LostBefore(now);
    SKYQUILT_TRY(FailExhausted(*db, lost_before));
    SKYQUILT_TRY_ASSIGN(
        Statement claim,
        db->Prepare(
            std::string("WITH next(a_job, a_kind, a_number) AS (SELECT u.job_id, u.kind, u.number FROM unit u"
                        " JOIN job j ON j.id=u.job_id WHERE j.state='running' AND j.cancel=0 AND"
                        " (u.state='waiting' OR (u.state='running' AND u.lease_until_us<?4))"
                        " ORDER BY j.priority DESC, j.id, u.number LIMIT 1") +
            PassOverLocked(*db) +
            ") UPDATE unit SET state='running', lease_token=lease_token+1, attempts=attempts+1, worker=?1,"
            " lease_until_us=" +
            LeaseEndSql(*db, "?2") +
            ", since_us=?3 FROM next WHERE job_id=a_job AND kind=a_kind AND number=a_number"
            " RETURNING job_id, kind, number, items, lease_token"));
    claim.Bind(1, worker).Bind(2, ToUs(now + kLeaseTime)).Bind(3, ToUs(now)).Bind(4, ToUs(lost_before));
    UnitLease unit;
    {
      SKYQUILT_TRY_ASSIGN(const bool row, claim.Step());
      if (!row) return std::optional<UnitLease>();
      unit.job_id = claim.ColumnText(0);
      unit.kind = claim.ColumnText(1);
      unit.number = static_cast<int>(claim.ColumnInt64(2));
      unit.items = claim.ColumnInt64(3);
      unit.token = claim.ColumnInt64(4);
      // RETURNING hands out its row before the statement is done; only done is committed.
      SKYQUILT_TRY(claim.Step());
    }
    SKYQUILT_TRY_ASSIGN(
        Statement job,
        db->Prepare("SELECT flight_id, options, (SELECT count(*) FROM unit WHERE job_id=?1 AND kind=?2),"
                    " units_of"
                    " FROM job WHERE id=?1"));
    SKYQUILT_TRY_ASSIGN(const bool row, job.Bind(1, unit.job_id).Bind(2, unit.kind).Step());
    if (!row) return std::optional<UnitLease>();  // deleted a moment ago, with its units
    unit.flight_id = job.ColumnText(0);
    unit.options = job.ColumnText(1);
    unit.count = static_cast<int>(job.ColumnInt64(2));
    unit.units_of = job.ColumnText(3);
    return std::optional<UnitLease>(std::move(unit));
  });
}

Result<LeaseState> UnitQueue::Renew(const UnitLease& unit, Time by_machine) {
  const auto db = db_.Lock();
  const Time now = db_.SharedTime(by_machine, *db);
  SKYQUILT_TRY_ASSIGN(Statement update,
                      db->Prepare("UPDATE unit SET lease_until_us=" + LeaseEndSql(*db, "?5") + kHeldUnit));
  SKYQUILT_TRY(BindUnit(update, unit).Bind(5, ToUs(now + kLeaseTime)).Run());
  if (db->Changes() == 0) return LeaseState::kLost;
  SKYQUILT_TRY_ASSIGN(Statement query, db->Prepare("SELECT cancel FROM job WHERE id=? AND state='running'"));
  SKYQUILT_TRY_ASSIGN(const bool row, query.Bind(1, unit.job_id).Step());
  if (!row) return LeaseState::kLost;
  return query.ColumnInt64(0) != 0 ? LeaseState::kCancelRequested : LeaseState::kHeld;
}

Result<bool> UnitQueue::Done(const UnitLease& unit) {
  return Patiently(db_, [&] { return DoneOnce(unit); });
}

Result<bool> UnitQueue::DoneOnce(const UnitLease& unit) {
  return db_.Again([&]() -> Result<bool> {
    const auto db = db_.Lock();
    SKYQUILT_TRY_ASSIGN(Transaction transaction, Transaction::Begin(*db));
    {
      SKYQUILT_TRY_ASSIGN(Statement update,
                          db->Prepare(std::string("UPDATE unit SET state='done', worker=''") + kHeldUnit));
      SKYQUILT_TRY(BindUnit(update, unit).Run());
      if (db->Changes() == 0) return false;
      SKYQUILT_TRY(GoOn(*db, unit.job_id, unit.kind));
    }
    SKYQUILT_TRY(transaction.Commit());
    return true;
  });
}

Result<bool> UnitQueue::Fail(const UnitLease& unit, const Error& error, bool may_retry, Time by_machine) {
  return db_.Again([&]() -> Result<bool> {
    const auto db = db_.Lock();
    const Time now = db_.SharedTime(by_machine, *db);
    SKYQUILT_TRY_ASSIGN(Transaction transaction, Transaction::Begin(*db));
    {
      SKYQUILT_TRY_ASSIGN(
          Statement update,
          db->Prepare(std::string("UPDATE unit SET state='waiting', worker='', waiting_us=?6") + kHeldUnit +
                      " AND attempts<?5"));
      if (may_retry) {
        SKYQUILT_TRY(BindUnit(update, unit).Bind(5, kMaxUnitAttempts).Bind(6, ToUs(now)).Run());
      }
      if (!may_retry || db->Changes() == 0) {
        SKYQUILT_TRY_ASSIGN(Statement held, db->Prepare(std::string("SELECT 1 FROM unit") + kHeldUnit));
        SKYQUILT_TRY_ASSIGN(const bool is_held, BindUnit(held, unit).Step());
        held.Reset();
        if (!is_held) return false;
        SKYQUILT_TRY(FailJobOf(*db, unit.job_id, error, now));
      } else {
        SKYQUILT_TRY(WakeWorkers(*db));
      }
    }
    SKYQUILT_TRY(transaction.Commit());
    return true;
  });
}

Result<bool> UnitQueue::GiveBack(const UnitLease& unit, Time by_machine) {
  const auto db = db_.Lock();
  const Time now = db_.SharedTime(by_machine, *db);
  SKYQUILT_TRY_ASSIGN(
      Statement update,
      db->Prepare(
          std::string("UPDATE unit SET state='waiting', worker='', attempts=attempts-1, waiting_us=?5") +
          kHeldUnit));
  SKYQUILT_TRY(BindUnit(update, unit).Bind(5, ToUs(now)).Run());
  const bool was_held = db->Changes() > 0;
  if (was_held) SKYQUILT_TRY(WakeWorkers(*db));
  return was_held;
}

Result<int> UnitQueue::CountTrouble(const UnitLease& unit) {
  const auto db = db_.Lock();
  SKYQUILT_TRY_ASSIGN(Statement count, db->Prepare(std::string("UPDATE unit SET troubles=troubles+1") +
                                                   kHeldUnit + " RETURNING troubles"));
  return NumberFrom(BindUnit(count, unit));
}

Result<int> UnitQueue::ReleaseWorker(const std::string& worker, WorkerEnd end, Time by_machine) {
  const auto db = db_.Lock();
  const Time now = db_.SharedTime(by_machine, *db);
  SKYQUILT_TRY_ASSIGN(
      Statement update,
      db->Prepare(std::string("UPDATE unit SET worker='', waiting_us=?2,") +
                  (end == WorkerEnd::kDied ? " lease_until_us=0" : " state='waiting', attempts=attempts-1") +
                  " WHERE state='running' AND worker=?1"));
  SKYQUILT_TRY(update.Bind(1, worker).Bind(2, ToUs(now)).Run());
  const int held = static_cast<int>(db->Changes());
  if (held > 0) SKYQUILT_TRY(WakeWorkers(*db));
  return held;
}

Result<std::vector<HeldUnit>> UnitQueue::Held(const std::string& job_id) const {
  constexpr int kMaxHeld = 1'000;
  const auto db = db_.Read();
  const Time now = db_.SharedTime(Now(), *db);
  // Those that a worker of the version before has do not say since when.
  SKYQUILT_TRY_ASSIGN(
      Statement query,
      db->Prepare("SELECT job_id, kind, number, worker, since_us, attempts FROM unit"
                  " WHERE state='running' AND lease_until_us>=?1 AND since_us>0 AND (?2='' OR job_id=?2)"
                  " ORDER BY job_id, kind, number LIMIT ?3"));
  query.Bind(1, ToUs(now)).Bind(2, job_id).Bind(3, kMaxHeld);
  std::vector<HeldUnit> units;
  while (true) {
    SKYQUILT_TRY_ASSIGN(const bool row, query.Step());
    if (!row) return units;
    units.push_back({std::string(query.ColumnText(0)), std::string(query.ColumnText(1)),
                     static_cast<int>(query.ColumnInt64(2)), std::string(query.ColumnText(3)),
                     FromUs(query.ColumnInt64(4)),
                     std::max(0.0, static_cast<double>(ToUs(now) - query.ColumnInt64(4)) * 1e-6),
                     static_cast<int>(query.ColumnInt64(5))});
  }
}

}  // namespace skyquilt::storage
