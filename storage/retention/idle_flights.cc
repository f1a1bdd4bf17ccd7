#include "storage/retention/idle_flights.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>
#include <string_view>

#include "core/base/try.h"

namespace skyquilt::storage {
namespace {

// So many flights are read, and then written, at a time: others wait no longer than for these.
constexpr int kFlightsAtATime = 200;

// ?2: now, by which shares end. What stands for a flight's files and jobs in one text each says whether any
// came, went or was replaced.
constexpr const char* kLook =
    "SELECT f.id, f.name, f.options || f.tags, coalesce(f.active_revision,0) || ' ' || f.next_revision,"
    " (SELECT count(*) || ' ' || coalesce(sum(bytes),0) || ' ' || coalesce(sum(created_us % 1000000000),0)"
    "  FROM file WHERE flight_id=f.id),"
    " (SELECT count(*) || ' ' || coalesce(max(id),'') || ' ' || coalesce(max(finished_us),0)"
    "  FROM job WHERE flight_id=f.id),"
    " f.is_kept<>0 OR EXISTS(SELECT 1 FROM job WHERE flight_id=f.id AND state IN ('accepted','running'))"
    " OR EXISTS(SELECT 1 FROM upload WHERE flight_id=f.id AND is_done=0)"
    " OR EXISTS(SELECT 1 FROM map_export WHERE flight_id=f.id)"
    " OR EXISTS(SELECT 1 FROM token WHERE flight_id=f.id AND (expires_us IS NULL OR expires_us>?2)),"
    " coalesce(i.seen,''), coalesce(i.since_us,0)"
    " FROM flight f LEFT JOIN idle_flight i ON i.flight_id=f.id WHERE f.deleted_us IS NULL AND ";

struct LookedAt {
  IdleFlight flight;
  std::string digest;
  bool is_in_use = false;
  std::string seen;  // the digest of before; empty: it is new
  Time since;

  bool IsAsBefore() const { return !is_in_use && digest == seen; }
  // Counted from a time that is still ahead (the AgeClock lost a few minutes to a power cut) it is not idle.
  bool IsIdle(Time age, std::chrono::microseconds keep) const { return IsAsBefore() && age - since >= keep; }
};

LookedAt LookedAtFrom(const Statement& row) {
  LookedAt found;
  found.flight = {std::string(row.ColumnText(0)), std::string(row.ColumnText(1))};
  std::string all;
  for (int column = 1; column <= 5; ++column) {
    const std::string_view part = row.ColumnText(column);
    all += fmt::format("{}:", part.size());
    all += part;
  }
  found.digest = fmt::format("{:016x}", XXH3_64bits(all.data(), all.size()));
  found.is_in_use = row.ColumnInt64(6) != 0;
  found.seen = row.ColumnText(7);
  found.since = FromUs(row.ColumnInt64(8));
  return found;
}

Result<std::vector<LookedAt>> FlightsAfter(SqlConnection& db, const std::string& id, Time now) {
  return db.All(LookedAtFrom,
                std::string(kLook) + fmt::format("f.id>?1 ORDER BY f.id LIMIT {}", kFlightsAtATime), id,
                ToUs(now));
}

Result<void> KeepSeen(SqlConnection& db, const std::vector<LookedAt>& looked, Time age) {
  SKYQUILT_TRY_ASSIGN(Transaction transaction, Transaction::Begin(db, "idle flights"));
  {
    // Of one that was removed meanwhile nothing is kept.
    SKYQUILT_TRY_ASSIGN(Statement keep,
                        db.Prepare(std::string("INSERT INTO idle_flight(flight_id,seen,since_us)"
                                               " SELECT id, CAST(?2 AS TEXT), ?3 FROM flight"
                                               " WHERE id=?1 AND deleted_us IS NULL") +
                                   db.ForShare() +
                                   " ON CONFLICT(flight_id) DO UPDATE SET seen=excluded.seen,"
                                   " since_us=excluded.since_us"));
    for (const LookedAt& one : looked) {
      if (one.IsAsBefore()) continue;
      SKYQUILT_TRY(keep.BindAll(one.flight.id, one.digest, ToUs(age)).Run());
    }
  }
  return transaction.Commit();
}

}  // namespace

Result<std::vector<IdleFlight>> IdleFlights::Look(Time age, Time now, std::chrono::microseconds keep) {
  std::vector<IdleFlight> idle;
  std::string last;
  while (true) {
    const auto looked = [&] {
      const auto db = db_.Read();
      return FlightsAfter(*db, last, now);
    }();
    if (!looked) return looked.error();
    if (looked->empty()) return idle;
    last = looked->back().flight.id;
    const auto write = [&] { return KeepSeen(*db_.Lock(), *looked, age); };
    const bool is_as_before =
        std::all_of(looked->begin(), looked->end(), [](const LookedAt& one) { return one.IsAsBefore(); });
    if (!is_as_before) SKYQUILT_TRY(db_.Again(write));
    for (const LookedAt& one : *looked) {
      if (one.IsIdle(age, keep)) idle.push_back(one.flight);
    }
  }
}

Result<bool> IdleFlights::IsIdle(SqlConnection& db, const std::string& flight_id, Time age, Time now,
                                 std::chrono::microseconds keep) {
  SKYQUILT_TRY_ASSIGN(const std::optional<LookedAt> found,
                      db.First(LookedAtFrom, std::string(kLook) + "f.id=?1", flight_id, ToUs(now)));
  return found && found->IsIdle(age, keep);
}

Result<void> IdleFlights::Forget() {
  const auto db = db_.Lock();
  return db->Change("DELETE FROM idle_flight");
}

}  // namespace skyquilt::storage
