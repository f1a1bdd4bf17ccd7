// UnitQueue: the units of jobs that are cut, for any number of workers. A job that is cut holds no worker: it
// waits until its units of one kind are done, is then claimed like any other (no attempt is counted for the
// waiting), and is cut again or made. Units go out by lease as jobs do: each write carries the unit's token,
// a unit whose worker is gone is handed out again, kMaxUnitAttempts times at most, then its job fails; a job
// that ends, however it ends, ends its units. What the units of a job that failed had made is kept for a day,
// for the next job that would make it from the same. Any thread, any number of processes. Time is given by
// the caller. Errors: as JobQueue.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "storage/db/catalogue_db.h"
#include "storage/db/clock.h"
#include "storage/jobs/job_queue.h"

namespace skyquilt::storage {

// After the end of a job that failed. Who sweeps waits a little longer than who takes over.
inline constexpr std::chrono::hours kUnitsKept{24};

// More than of jobs: a restart of a worker's machine is not told from its death here.
inline constexpr int kMaxUnitAttempts = 5;

struct UnitLease {
  std::string job_id;
  std::string flight_id;
  std::string options;   // of the job
  std::string units_of;  // as UnitsOf
  std::string kind;
  int number = 0;
  int count = 1;           // units of this kind
  std::int64_t items = 0;  // that the units of this kind share: files, blocks
  std::int64_t token = 0;
};

// The units of one kind of a job.
struct UnitCount {
  std::string kind;
  int count = 0;
  int done = 0;
  std::int64_t items = 0;
};

// The units of one kind of all jobs that are cut and have not ended.
struct UnitsOfKind {
  std::string kind;
  int waiting = 0;  // those whose workers are gone among them
  int running = 0;
  int done = 0;
  int failed_attempts = 0;         // of these units: attempts that came to nothing
  double longest_waiting_s = 0.0;  // of those that wait
};

// A unit that a worker has.
struct HeldUnit {
  std::string job_id;
  std::string kind;
  int number = 0;
  std::string worker;
  Time since;         // it has it
  double held_s = 0;  // by the database's clock
  int attempt = 1;
};

// Where the job is in its progress while its units are at work.
struct UnitProgress {
  double from = 0.0;  // 0..1 over the whole job, when none is done
  double to = 1.0;    // when all are
  std::string stage;
};

// Whether a row of `unit` may be claimed at the time `at`, in SQL: the name of the table and a parameter.
// SQLite has the index of the open ones, of the few among many that are done, only where its own words stand
// here.
std::string MayBeClaimed(std::string_view unit, std::string_view at);

class UnitQueue {
 public:
  explicit UnitQueue(CatalogueDb& db) : db_(db) {}

  // Before the first cut: the id of the job under whose id the units of this one lie: its own, or that of one
  // of the same flight that failed, whose units were made from the same (`made_from`, see UnitInputs).
  // Nothing: the lease was lost.
  Result<std::optional<std::string>> TakeOver(const Lease& lease, std::string_view made_from, Time now);
  // Before a program of this version makes a unit of the job: where another cut it, nobody takes over its
  // units, which are of both.
  Result<void> MakeAs(const std::string& job_id, std::string_view version);
  // As TakeOver answered, once the job is cut; empty before.
  Result<std::string> UnitsOf(const std::string& job_id) const;
  // The leased job waits for `count` units of `kind`, of which those it had already are kept and those of
  // `done` are done; the lease is over. False: it was lost before.
  Result<bool> Cut(const Lease& lease, std::string_view kind, int count, std::int64_t items,
                   const UnitProgress& progress, const std::set<int>& done = {});
  Result<std::vector<UnitCount>> Of(const std::string& job_id) const;
  // Kinds of which there are none are left out.
  Result<std::vector<UnitsOfKind>> Count(Time now) const;

  Result<std::optional<UnitLease>> Claim(std::string_view worker, Time now);
  Result<LeaseState> Renew(const UnitLease& unit, Time now);
  // The last one of its kind lets the job be claimed. As Cut, tries for a minute while a shared catalogue's
  // database cannot be reached. False: the lease was lost.
  Result<bool> Done(const UnitLease& unit);
  // With `may_retry` the unit waits for another attempt if any is left; else its job fails. False: the lease
  // was lost.
  Result<bool> Fail(const UnitLease& unit, const Error& error, bool may_retry, Time now);
  // The worker must stop, or its machine is in trouble, through no fault of the unit's.
  Result<bool> GiveBack(const UnitLease& unit, Time now);
  // As JobQueue::CountTrouble, for the unit.
  Result<int> CountTrouble(const UnitLease& unit);
  // A worker process ended, or does not know what it has: its units wait for the next one now. One that was
  // interrupted loses no attempt by it. Answers how many it held.
  Result<int> ReleaseWorker(const std::string& worker, WorkerEnd end, Time now);

  // Who has which, of one job or (empty) of all.
  Result<std::vector<HeldUnit>> Held(const std::string& job_id = "") const;

 private:
  CatalogueDb& db_;
};

}  // namespace skyquilt::storage
