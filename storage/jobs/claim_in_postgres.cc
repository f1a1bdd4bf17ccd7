#include "storage/jobs/claim_in_postgres.h"

#include <fmt/format.h>

#include "core/base/try.h"
#include "storage/db/machine_boot.h"
#include "storage/jobs/job_rows.h"
#include "storage/jobs/lost_leases.h"

namespace skyquilt::storage {
namespace {

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
