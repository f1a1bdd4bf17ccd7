#include "storage/db/age_clock.h"

#include <optional>

#include "core/base/try.h"
#include "storage/db/machine_boot.h"

namespace skyquilt::storage {

namespace {

Error ClockIsLost() { return {ErrorCode::kCorrupt, "The catalogue has lost its clock. Restore it.", ""}; }

// The shared clock, put forward to now.
Result<Time> PutForward(SqlConnection& db) {
  constexpr std::chrono::microseconds kMaxStep = std::chrono::hours(1);
  return db.One(FirstColumn<Time>, ClockIsLost(),
                "UPDATE age_clock SET age_us=age_us+greatest(0,least(now_us()-seen_us,?)),"
                " seen_us=now_us() RETURNING age_us",
                static_cast<std::int64_t>(kMaxStep.count()));
}

}  // namespace

Result<AgeClock> AgeClock::Open(SqlConnection& db) {
  if (db.dialect() == Dialect::kPostgres) {
    SKYQUILT_TRY_ASSIGN(const Time now, PutForward(db));
    return AgeClock(now - MachineBoot::Elapsed());
  }
  const auto read = [&] {
    return db.First(FirstColumn<Time>, "SELECT age_us-since_boot_us FROM age_clock WHERE boot_id=?",
                    MachineBoot::Id());
  };
  Result<std::optional<Time>> known = read();
  if (!known) return known.error();
  if (!*known) {
    // The first to look after the machine started. Another process may do the same: one of the two changes
    // the row.
    SKYQUILT_TRY(db.Change("UPDATE age_clock SET boot_id=?1, since_boot_us=?2 WHERE boot_id<>?1",
                           MachineBoot::Id(), MachineBoot::Elapsed().count()));
    known = read();
    if (!known) return known.error();
    if (!*known) return ClockIsLost();
  }
  return AgeClock(**known);
}

Time AgeClock::Now() const { return FromUs(at_boot_us_) + MachineBoot::Elapsed(); }

Result<void> AgeClock::Save(SqlConnection& db) {
  if (db.dialect() == Dialect::kPostgres) {
    SKYQUILT_TRY_ASSIGN(const Time now, PutForward(db));
    at_boot_us_ = ToUs(now - MachineBoot::Elapsed());
    return {};
  }
  const std::chrono::microseconds elapsed = MachineBoot::Elapsed();
  return db.Change("UPDATE age_clock SET age_us=?1, since_boot_us=?2 WHERE boot_id=?3 AND age_us<?1",
                   at_boot_us_ + elapsed.count(), elapsed.count(), MachineBoot::Id());
}

}  // namespace skyquilt::storage
