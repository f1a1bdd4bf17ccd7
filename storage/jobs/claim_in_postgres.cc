#include "storage/jobs/claim_in_postgres.h"

#include <string>

#include "core/base/try.h"
#include "storage/db/machine_boot.h"
#include "storage/jobs/lost_leases.h"

namespace skyquilt::storage {
namespace {

// Nobody could renew a lease while the database was down: one that ran out meanwhile has its time once more,
// from the start of the database. Leases that were released (no worker) stay released.
Result<void> GiveTimeAfterStart(SqlConnection& db, Time now) {
  constexpr const char* kStart = "CAST(extract(epoch FROM pg_postmaster_start_time())*1000000 AS BIGINT)";
  SKYQUILT_TRY_ASSIGN(Statement extend, db.Prepare(std::string("UPDATE job SET lease_until_us=") + kStart +
                                                   "+?2 WHERE state='running' AND worker NOT IN ('','units')"
                                                   " AND lease_until_us<?1 AND ?1<" +
                                                   kStart + "+?2"));
  constexpr std::chrono::microseconds kLease = kLeaseTime;
  return extend.Bind(1, ToUs(now)).Bind(2, static_cast<std::int64_t>(kLease.count())).Run();
}

Result<void> LetWaitAgain(SqlConnection& db, Time now) {
  SKYQUILT_TRY_ASSIGN(Transaction transaction, Transaction::Begin(db, "leases that ran out"));
  SKYQUILT_TRY(GiveTimeAfterStart(db, now));
  SKYQUILT_TRY(SettleLostLeases(db, now));
  SKYQUILT_TRY_ASSIGN(Statement wait, db.Prepare("UPDATE job SET state='accepted', not_before_us=0,"
                                                 " worker=CASE worker WHEN 'units' THEN worker ELSE '' END"
                                                 " WHERE state='running' AND lease_until_us<?"));
  SKYQUILT_TRY(wait.Bind(1, ToUs(now)).Run());
  return transaction.Commit();
}

}  // namespace

Result<std::optional<Lease>> ClaimInPostgres(SqlConnection& db, std::string_view worker, Time now) {
  // The commit of a claim waits for no disk.
  SKYQUILT_TRY_ASSIGN(const UnsyncedCommits unsynced, UnsyncedCommits::Begin(db));
  for (const bool is_settled : {false, true}) {
    SKYQUILT_TRY_ASSIGN(
        Statement claim,
        db.Prepare("SELECT job_id, of_flight, with_options, token, attempt FROM claim_job(?,?,?,?,?)"));
    claim.Bind(1, worker).Bind(2, ToUs(now)).Bind(3, ToUs(now + kLeaseTime)).Bind(4, MachineBoot::Id());
    SKYQUILT_TRY_ASSIGN(const bool row, claim.Bind(5, is_settled ? 1 : 0).Step());
    if (!row) break;
    if (!claim.IsNull(0)) {
      return std::optional(Lease{std::string(claim.ColumnText(0)), std::string(claim.ColumnText(1)),
                                 std::string(claim.ColumnText(2)), claim.ColumnInt64(3),
                                 static_cast<int>(claim.ColumnInt64(4))});
    }
    SKYQUILT_TRY(LetWaitAgain(db, now));
  }
  return std::optional<Lease>();
}

}  // namespace skyquilt::storage
