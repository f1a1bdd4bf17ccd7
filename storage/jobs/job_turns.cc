#include "storage/jobs/job_turns.h"

#include <fmt/format.h>

#include <algorithm>
#include <compare>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "core/base/try.h"
#include "storage/db/machine_boot.h"
#include "storage/jobs/job_leases.h"
#include "storage/jobs/job_rows.h"

namespace skyquilt::storage {
namespace {

// Smaller comes first.
struct Turn {
  std::int64_t below_priority = 0;  // the priority, negated
  std::int64_t running = 0;
  std::int64_t last_us = 0;
  std::string job_id;
  auto operator<=>(const Turn&) const = default;
};

void KeepFirst(Turn turn, std::optional<Turn>& first) {
  if (!first || turn < *first) first = std::move(turn);
}

// Jobs under a live lease, by owner. As many rows as there are workers.
Result<std::map<std::string, std::int64_t>> RunningByOwner(SqlConnection& db, Time now) {
  SKYQUILT_TRY_ASSIGN(
      Statement query,
      db.Query("SELECT owner, count(*) FROM job WHERE state='running' AND lease_until_us>=? GROUP BY owner",
               ToUs(now)));
  std::map<std::string, std::int64_t> running;
  SKYQUILT_TRY(query.Each(
      [&](const Statement& row) { running[std::string(row.ColumnText(0))] = row.ColumnInt64(1); }));
  return running;
}

Result<std::string> FirstOf(SqlConnection& db, const std::string& owner, std::int64_t priority, Time now) {
  return db.Text(
      "SELECT id FROM job WHERE state='accepted' AND owner=?1 AND priority=?2 AND not_before_us<=?3"
      " ORDER BY id LIMIT 1",
      owner, priority, ToUs(now));
}

// Of the jobs that wait. Along the index: by priority, then whose turn is longest ago, then who came first.
// Within a priority an owner with nothing running goes first; the others follow by how much each has running.
Result<std::optional<Turn>> FirstWaiting(SqlConnection& db,
                                         const std::map<std::string, std::int64_t>& running, Time now) {
  struct Busy {
    std::int64_t running = 0;
    std::int64_t last_us = 0;
    std::string owner;
  };
  std::vector<Busy> passed;  // of one priority
  std::int64_t priority = 0;
  const auto first_of_passed = [&]() -> Result<std::optional<Turn>> {
    std::stable_sort(passed.begin(), passed.end(),
                     [](const Busy& a, const Busy& b) { return a.running < b.running; });
    for (const Busy& busy : passed) {
      SKYQUILT_TRY_ASSIGN(std::string job, FirstOf(db, busy.owner, priority, now));
      if (!job.empty()) return std::optional(Turn{-priority, busy.running, busy.last_us, std::move(job)});
    }
    passed.clear();
    return std::optional<Turn>();
  };
  SKYQUILT_TRY_ASSIGN(
      Statement owners,
      db.Prepare(
          "SELECT priority, last_us, owner FROM turn ORDER BY priority DESC, last_us, first_id, owner"));
  while (true) {
    SKYQUILT_TRY_ASSIGN(const bool row, owners.Step());
    if (!row) return first_of_passed();
    if (!passed.empty() && priority != owners.ColumnInt64(0)) {
      Result<std::optional<Turn>> turn = first_of_passed();
      if (!turn || *turn) return turn;
    }
    priority = owners.ColumnInt64(0);
    const std::int64_t last_us = owners.ColumnInt64(1);
    std::string owner(owners.ColumnText(2));
    if (const auto held = running.find(owner); held != running.end()) {
      passed.push_back({held->second, last_us, std::move(owner)});
      continue;
    }
    SKYQUILT_TRY_ASSIGN(std::string job, FirstOf(db, owner, priority, now));
    if (!job.empty()) return std::optional(Turn{-priority, 0, last_us, std::move(job)});
  }
}

// Of the jobs whose leases ran out: as many at most as there were workers.
Result<void> AddAbandoned(SqlConnection& db, const std::map<std::string, std::int64_t>& running, Time now,
                          std::optional<Turn>& first) {
  SKYQUILT_TRY_ASSIGN(
      Statement query,
      db.Query("SELECT id, owner, priority, (SELECT coalesce(max(s.attempt_started_us),0) FROM job s WHERE"
               " s.owner=job.owner) FROM job WHERE state='running' AND lease_until_us<?",
               ToUs(now)));
  return query.Each([&](const Statement& row) {
    const auto held = running.find(std::string(row.ColumnText(1)));
    KeepFirst({-row.ColumnInt64(2), held == running.end() ? 0 : held->second, row.ColumnInt64(3),
               std::string(row.ColumnText(0))},
              first);
  });
}

// Absent: nothing waits, or nothing that may begin already. Within the caller's transaction.
Result<std::optional<std::string>> NextJob(SqlConnection& db, Time now) {
  SKYQUILT_TRY_ASSIGN(const auto running, RunningByOwner(db, now));
  std::optional<Turn> first;
  SKYQUILT_TRY(AddAbandoned(db, running, now, first));
  SKYQUILT_TRY_ASSIGN(std::optional<Turn> waiting, FirstWaiting(db, running, now));
  if (waiting) KeepFirst(*std::move(waiting), first);
  if (!first) return std::optional<std::string>();
  return std::optional<std::string>(std::move(first->job_id));
}

Result<void> LetWaitAgain(SqlConnection& db, Time now) {
  SKYQUILT_TRY_ASSIGN(Transaction transaction, Transaction::Begin(db, "leases that ran out"));
  SKYQUILT_TRY(GiveTimeAfterStart(db, now));
  SKYQUILT_TRY(SettleLostLeases(db, now));
  SKYQUILT_TRY(
      db.Change("UPDATE job SET state='accepted', not_before_us=0,"
                " worker=CASE worker WHEN 'units' THEN worker ELSE '' END"
                " WHERE state='running' AND lease_until_us<?",
                ToUs(now)));
  return transaction.Commit();
}

}  // namespace

Result<std::optional<Lease>> ClaimInFolder(SqlConnection& db, std::string_view worker, Time now) {
  // An idle worker only reads; the write lock is taken when there is something to take.
  SKYQUILT_TRY_ASSIGN(
      const std::int64_t may_claim,
      db.Number("SELECT EXISTS(SELECT 1 FROM job WHERE state='accepted' AND not_before_us<=?1)"
                " OR EXISTS(SELECT 1 FROM job WHERE state='running' AND lease_until_us<?1)",
                ToUs(now)));
  if (may_claim == 0) return std::optional<Lease>();
  // A claim that a power cut undoes leaves the job waiting, as it should be: its worker is gone as well.
  SKYQUILT_TRY_ASSIGN(const UnsyncedCommits unsynced, UnsyncedCommits::Begin(db));
  SKYQUILT_TRY_ASSIGN(Transaction transaction, Transaction::Begin(db));
  SKYQUILT_TRY(SettleLostLeases(db, now));
  std::optional<Lease> lease;
  SKYQUILT_TRY_ASSIGN(const std::optional<std::string> next, NextJob(db, now));
  if (next) {
    SKYQUILT_TRY_ASSIGN(
        lease,
        db.First(
            LeaseFrom,
            "UPDATE job SET state='running', lease_token=lease_token+1, attempts=attempts+1, worker=?1,"
            " lease_until_us=?2, started_us=coalesce(started_us,?3), "
            " attempt_started_us=CASE worker WHEN 'units' THEN attempt_started_us ELSE ?3 END,"
            " stage=CASE worker WHEN 'units' THEN stage ELSE '' END,"
            " progress=CASE worker WHEN 'units' THEN progress ELSE 0 END, message='', claimed_in=?5 WHERE id=?4 RETURNING id, flight_id, options, lease_token, attempts",
            worker, ToUs(now + kLeaseTime), ToUs(now), *next, MachineBoot::Id()));
  }
  SKYQUILT_TRY(transaction.Commit());
  return lease;
}

Result<void> GiveTimeAfterStart(SqlConnection& db, Time now) {
  constexpr const char* kStart = "CAST(extract(epoch FROM pg_postmaster_start_time())*1000000 AS BIGINT)";
  constexpr std::chrono::microseconds kLease = kLeaseTime;
  for (const char* table : {"unit", "job"}) {
    SKYQUILT_TRY(db.Change(fmt::format("UPDATE {} SET lease_until_us={}+?2 WHERE state='running'"
                                       " AND worker NOT IN ('','units') AND lease_until_us<?1 AND ?1<{}+?2",
                                       table, kStart, kStart),
                           ToUs(now), static_cast<std::int64_t>(kLease.count())));
  }
  return {};
}

Result<std::optional<Lease>> ClaimInPostgres(SqlConnection& db, std::string_view worker, Time now,
                                             Time lost_before) {
  // The commit of a claim waits for no disk.
  SKYQUILT_TRY_ASSIGN(const UnsyncedCommits unsynced, UnsyncedCommits::Begin(db));
  for (bool is_settled = lost_before < now;; is_settled = true) {
    SKYQUILT_TRY_ASSIGN(
        Statement claim,
        db.Query(fmt::format(
                     "SELECT job_id, of_flight, with_options, token, attempt FROM claim_job(?1,?2,{},?4,?5)",
                     LeaseEndSql(db, "?3")),
                 worker, ToUs(now), ToUs(now + kLeaseTime), MachineBoot::Id(), is_settled ? 1 : 0));
    SKYQUILT_TRY_ASSIGN(const bool row, claim.Step());
    if (!row) return std::optional<Lease>();
    if (!claim.IsNull(0)) return std::optional(LeaseFrom(claim));
    SKYQUILT_TRY(LetWaitAgain(db, now));
  }
}

}  // namespace skyquilt::storage
