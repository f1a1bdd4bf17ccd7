#include "storage/jobs/unit_queue.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/try.h"
#include "core/flight/remarks/because.h"
#include "storage/db/machine_boot.h"
#include "storage/jobs/job_rows.h"
#include "storage/jobs/job_turns.h"

namespace skyquilt::storage {
namespace {

constexpr const char* kHeldUnit =
    " WHERE job_id=?1 AND kind=?2 AND number=?3 AND lease_token=?4 AND state='running'";

// What is to be set of the leased unit; `values` are ?5 and on. False: the lease was lost.
template <typename... Values>
Result<bool> ChangeHeldUnit(SqlConnection& db, const UnitLease& unit, const std::string& set,
                            const Values&... values) {
  SKYQUILT_TRY(db.Change("UPDATE unit SET " + set + kHeldUnit, unit.job_id, unit.kind, unit.number,
                         unit.token, values...));
  return db.Changes() > 0;
}

Result<void> FailJobOf(SqlConnection& db, const std::string& job_id, const Error& error, Time now) {
  return db.Change(
      "UPDATE job SET state=CASE cancel WHEN 1 THEN 'dismissed' ELSE 'failed' END,"
      " finished_us=?2, worker='', error_code=CASE cancel WHEN 1 THEN NULL ELSE ?3 END,"
      " error_message=CASE cancel WHEN 1 THEN NULL ELSE ?4 END,"
      " error_reason=CASE cancel WHEN 1 THEN '' ELSE ?5 END"
      " WHERE id=?1 AND state='running'",
      job_id, ToUs(now), ErrorCodeName(error.code), error.message, ReasonText(error));
}

// Rows that another claim is taking are left to it.
const char* PassOverLocked(const SqlConnection& db) {
  return db.dialect() == Dialect::kPostgres ? " FOR UPDATE OF u SKIP LOCKED" : "";
}

// Units whose workers died again and again end their jobs.
Result<void> FailExhausted(SqlConnection& db, Time now) {
  SKYQUILT_TRY_ASSIGN(
      const std::vector<std::string> jobs,
      db.AllText(
          "SELECT DISTINCT job_id FROM unit WHERE state<>'done' AND state='running' AND lease_until_us<?1 AND attempts>=?2",
          ToUs(now), kMaxUnitAttempts));
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
      db.Query("SELECT count(*), count(*) FILTER (WHERE state='done') FROM unit WHERE job_id=?1 AND kind=?2",
               job_id, kind));
  SKYQUILT_TRY(query.Step());
  const std::int64_t count = query.ColumnInt64(0), done = query.ColumnInt64(1);
  query.Reset();
  if (done == count) SKYQUILT_TRY(WakeWorkers(db));
  return db.Change(
      "UPDATE job SET progress=units_from+(units_to-units_from)*?2, message=?3,"
      " lease_until_us=CASE WHEN ?4=1 THEN 0 ELSE lease_until_us END, claimed_in=?5"
      " WHERE id=?1 AND state='running' AND worker='units'",
      job_id, count > 0 ? static_cast<double>(done) / static_cast<double>(count) : 1.0,
      fmt::format("part {} of {} is done", done, count), done == count ? 1 : 0, MachineBoot::Id());
}

UnitLease UnitFrom(const Statement& row) {
  UnitLease unit;
  row.Into(unit.job_id, unit.kind, unit.number, unit.items, unit.token);
  return unit;
}

}  // namespace

std::string MayBeClaimed(std::string_view unit, std::string_view at) {
  return fmt::format(
      "{0}.state<>'done' AND ({0}.state='waiting' OR ({0}.state='running' AND {0}.lease_until_us<{1}))", unit,
      at);
}

Result<bool> UnitQueue::Cut(const Lease& lease, std::string_view kind, int count, std::int64_t items,
                            const UnitProgress& progress, const std::set<int>& done) {
  const auto cut = [&]() -> Result<bool> {
    const auto db = db_.Lock();
    SKYQUILT_TRY_ASSIGN(Transaction transaction, Transaction::Begin(*db));
    SKYQUILT_TRY(
        db->Change("UPDATE job SET worker='units', lease_until_us=?3, lease_token=lease_token+1,"
                   " attempts=attempts-1, stage=?4, units_from=?5, units_to=?6,"
                   " units_of=CASE units_of WHEN '' THEN id ELSE units_of END"
                   " WHERE id=?1 AND lease_token=?2 AND state='running'",
                   lease.job_id, lease.token, kUnitsLeaseUs, progress.stage, progress.from, progress.to));
    if (db->Changes() == 0) return false;
    // Somebody wished to cancel it while its worker was here: nobody would see that now.
    const std::int64_t now_us = ToUs(db_.SharedTime(Now(), *db));
    SKYQUILT_TRY(
        db->Change("UPDATE job SET state='dismissed', worker='', finished_us=?2"
                   " WHERE id=?1 AND state='running' AND cancel=1",
                   lease.job_id, now_us));
    const bool is_dismissed = db->Changes() > 0;
    {
      SKYQUILT_TRY_ASSIGN(Statement add,
                          db->Prepare("INSERT INTO unit(job_id,kind,number,items,state,waiting_us)"
                                      " VALUES(?,?,?,?,?,?) ON CONFLICT DO NOTHING"));
      for (int number = 0; number < count && !is_dismissed; ++number) {
        const char* state = done.contains(number) ? "done" : "waiting";
        SKYQUILT_TRY(add.BindAll(lease.job_id, kind, number, items, state, now_us).Run());
      }
    }
    SKYQUILT_TRY(GoOn(*db, lease.job_id, kind));
    SKYQUILT_TRY(transaction.Commit());
    return true;
  };
  return db_.Patiently([&] { return db_.Again(cut); });
}

Result<std::vector<UnitCount>> UnitQueue::Of(const std::string& job_id) const {
  const auto db = db_.Read();
  return db->All(RowOf<UnitCount, std::string, int, int, std::int64_t>,
                 "SELECT kind, count(*), count(*) FILTER (WHERE state='done'), max(items)"
                 " FROM unit WHERE job_id=? GROUP BY kind ORDER BY kind",
                 job_id);
}

Result<std::vector<UnitsOfKind>> UnitQueue::Count(Time by_machine) const {
  const auto db = db_.Read();
  const Time now = db_.SharedTime(by_machine, *db);
  SKYQUILT_TRY_ASSIGN(
      Statement query,
      db->Query("WITH seen AS (SELECT kind, attempts,"
                " CASE WHEN state='running' AND lease_until_us<?1 THEN 'waiting' ELSE state END AS state,"
                " CASE WHEN state='running' AND lease_until_us>waiting_us THEN lease_until_us"
                " ELSE waiting_us END AS since_us FROM unit)"
                " SELECT kind, count(*) FILTER (WHERE state='waiting'),"
                " count(*) FILTER (WHERE state='running'), count(*) FILTER (WHERE state='done'),"
                " sum(CASE state WHEN 'waiting' THEN attempts ELSE attempts-1 END),"
                " min(CASE state WHEN 'waiting' THEN since_us END) FROM seen GROUP BY kind ORDER BY kind",
                ToUs(now)));
  return query.All([&](const Statement& row) {
    auto kind = RowOf<UnitsOfKind, std::string, int, int, int, int>(row);
    if (kind.waiting > 0)
      kind.longest_waiting_s = std::max(0.0, static_cast<double>(ToUs(now) - row.ColumnInt64(5)) * 1e-6);
    return kind;
  });
}

Result<std::optional<UnitLease>> UnitQueue::Claim(std::string_view worker, Time by_machine) {
  return db_.Again([&]() -> Result<std::optional<UnitLease>> {
    {
      // As with jobs, an idle worker only reads.
      const auto db = db_.Read();
      const Time now = db_.SharedTime(by_machine, *db);
      SKYQUILT_TRY_ASSIGN(const std::int64_t may_claim,
                          db->Number("SELECT CASE WHEN EXISTS(SELECT 1 FROM unit WHERE " +
                                         MayBeClaimed("unit", "?1") + ") THEN 1 ELSE 0 END",
                                     ToUs(db_.LostBefore(now))));
      if (may_claim == 0) return std::optional<UnitLease>();
    }
    const auto db = db_.Lock();
    const Time now = db_.SharedTime(by_machine, *db);
    if (db_.IsShared()) SKYQUILT_TRY(GiveTimeAfterStart(*db, now));
    const Time lost_before = db_.LostBefore(now);
    SKYQUILT_TRY(FailExhausted(*db, lost_before));
    SKYQUILT_TRY_ASSIGN(
        std::optional<UnitLease> unit,
        db->First(
            UnitFrom,
            std::string("WITH next(a_job, a_kind, a_number) AS (SELECT u.job_id, u.kind, u.number FROM unit u"
                        " JOIN job j ON j.id=u.job_id WHERE j.state='running' AND j.cancel=0 AND ") +
                MayBeClaimed("u", "?4") + " ORDER BY j.priority DESC, j.id, u.number LIMIT 1" +
                PassOverLocked(*db) +
                ") UPDATE unit SET state='running', lease_token=lease_token+1, attempts=attempts+1, worker=?1,"
                " lease_until_us=" +
                LeaseEndSql(*db, "?2") +
                ", since_us=?3 FROM next WHERE job_id=a_job AND kind=a_kind AND number=a_number"
                " RETURNING job_id, kind, number, items, lease_token",
            worker, ToUs(now + kLeaseTime), ToUs(now), ToUs(lost_before)));
    if (!unit) return unit;
    SKYQUILT_TRY_ASSIGN(
        Statement job,
        db->Query("SELECT flight_id, options, (SELECT count(*) FROM unit WHERE job_id=?1 AND kind=?2),"
                  " units_of FROM job WHERE id=?1",
                  unit->job_id, unit->kind));
    SKYQUILT_TRY_ASSIGN(const bool row, job.Step());
    if (!row) return std::optional<UnitLease>();  // deleted a moment ago, with its units
    job.Into(unit->flight_id, unit->options, unit->count, unit->units_of);
    return unit;
  });
}

Result<LeaseState> UnitQueue::Renew(const UnitLease& unit, Time by_machine) {
  const auto db = db_.Lock();
  const Time now = db_.SharedTime(by_machine, *db);
  SKYQUILT_TRY_ASSIGN(
      const bool is_held,
      ChangeHeldUnit(*db, unit, "lease_until_us=" + LeaseEndSql(*db, "?5"), ToUs(now + kLeaseTime)));
  if (!is_held) return LeaseState::kLost;
  SKYQUILT_TRY_ASSIGN(Statement query,
                      db->Query("SELECT cancel FROM job WHERE id=? AND state='running'", unit.job_id));
  return LeaseStateFrom(query);
}

Result<bool> UnitQueue::Done(const UnitLease& unit) {
  const auto end = [&]() -> Result<bool> {
    const auto db = db_.Lock();
    SKYQUILT_TRY_ASSIGN(Transaction transaction, Transaction::Begin(*db));
    SKYQUILT_TRY_ASSIGN(const bool was_held, ChangeHeldUnit(*db, unit, "state='done', worker=''"));
    if (!was_held) return false;
    SKYQUILT_TRY(GoOn(*db, unit.job_id, unit.kind));
    SKYQUILT_TRY(transaction.Commit());
    return true;
  };
  return db_.Patiently([&] { return db_.Again(end); });
}

Result<bool> UnitQueue::Fail(const UnitLease& unit, const Error& error, bool may_retry, Time by_machine) {
  return db_.Again([&]() -> Result<bool> {
    const auto db = db_.Lock();
    const Time now = db_.SharedTime(by_machine, *db);
    SKYQUILT_TRY_ASSIGN(Transaction transaction, Transaction::Begin(*db));
    bool waits_again = false;
    if (may_retry) {
      SKYQUILT_TRY(db->Change(std::string("UPDATE unit SET state='waiting', worker='', waiting_us=?6") +
                                  kHeldUnit + " AND attempts<?5",
                              unit.job_id, unit.kind, unit.number, unit.token, kMaxUnitAttempts, ToUs(now)));
      waits_again = db->Changes() > 0;
    }
    if (waits_again) {
      SKYQUILT_TRY(WakeWorkers(*db));
    } else {
      SKYQUILT_TRY_ASSIGN(const bool is_held, db->Finds(std::string("SELECT 1 FROM unit") + kHeldUnit,
                                                        unit.job_id, unit.kind, unit.number, unit.token));
      if (!is_held) return false;
      SKYQUILT_TRY(FailJobOf(*db, unit.job_id, error, now));
    }
    SKYQUILT_TRY(transaction.Commit());
    return true;
  });
}

Result<bool> UnitQueue::GiveBack(const UnitLease& unit, Time by_machine) {
  const auto db = db_.Lock();
  const Time now = db_.SharedTime(by_machine, *db);
  SKYQUILT_TRY_ASSIGN(
      const bool was_held,
      ChangeHeldUnit(*db, unit, "state='waiting', worker='', attempts=attempts-1, waiting_us=?5", ToUs(now)));
  if (was_held) SKYQUILT_TRY(WakeWorkers(*db));
  return was_held;
}

Result<int> UnitQueue::CountTrouble(const UnitLease& unit) {
  const auto db = db_.Lock();
  SKYQUILT_TRY_ASSIGN(
      const std::int64_t troubles,
      db->Number(std::string("UPDATE unit SET troubles=troubles+1") + kHeldUnit + " RETURNING troubles",
                 unit.job_id, unit.kind, unit.number, unit.token));
  return static_cast<int>(troubles);
}

Result<int> UnitQueue::ReleaseWorker(const std::string& worker, WorkerEnd end, Time by_machine) {
  const auto db = db_.Lock();
  const Time now = db_.SharedTime(by_machine, *db);
  SKYQUILT_TRY(db->Change(
      std::string("UPDATE unit SET worker='', waiting_us=?2,") +
          (end == WorkerEnd::kDied ? " lease_until_us=0" : " state='waiting', attempts=attempts-1") +
          " WHERE state='running' AND worker=?1",
      worker, ToUs(now)));
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
      db->Query("SELECT job_id, kind, number, worker, since_us, attempts FROM unit"
                " WHERE state='running' AND lease_until_us>=?1 AND since_us>0 AND (?2='' OR job_id=?2)"
                " ORDER BY job_id, kind, number LIMIT ?3",
                ToUs(now), job_id, kMaxHeld));
  return query.All([&](const Statement& row) {
    HeldUnit unit;
    row.Into(unit.job_id, unit.kind, unit.number, unit.worker, unit.since, unit.attempt);
    unit.held_s = std::max(0.0, static_cast<double>(ToUs(now) - ToUs(unit.since)) * 1e-6);
    return unit;
  });
}

}  // namespace skyquilt::storage
