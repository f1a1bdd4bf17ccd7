#include "storage/db/age_clock.h"

#include <optional>

#include "core/base/try.h"
#include "storage/db/machine_boot.h"

namespace skyquilt::storage {

namespace {

// The shared clock, put forward to now.
Result<Time> PutForward(SqlConnection& db) {
  SKYQUILT_TRY_ASSIGN(Statement update,
                      db.Prepare("UPDATE age_clock SET age_us=age_us+greatest(0,least(now_us()-seen_us,?)),"
                                 " seen_us=now_us() RETURNING age_us"));
  constexpr std::chrono::microseconds kMaxStep = std::chrono::hours(1);
  SKYQUILT_TRY_ASSIGN(const bool row, update.Bind(1, static_cast<std::int64_t>(kMaxStep.count())).Step());
  if (!row) return Error{ErrorCode::kCorrupt, "The catalogue has lost its clock. Restore it.", ""};
  return FromUs(update.ColumnInt64(0));
}

}  // namespace

Result<AgeClock> AgeClock::Open(SqlConnection& db) {
  if (db.dialect() == Dialect::kPostgres) {
    SKYQUILT_TRY_ASSIGN(const Time now, PutForward(db));
    return AgeClock(now - MachineBoot::Elapsed());
  }
  const auto read = [&]() -> Result<std::optional<Time>> {
    SKYQUILT_TRY_ASSIGN(Statement query,
                        db.Prepare("SELECT age_us, since_boot_us FROM age_clock WHERE boot_id=?"));
    SKYQUILT_TRY_ASSIGN(const bool row, query.Bind(1, MachineBoot::Id()).Step());
    if (!row) return std::optional<Time>();
    return std::optional<Time>(FromUs(query.ColumnInt64(0) - query.ColumnInt64(1)));
  };
  Result<std::optional<Time>> known = read();
  if (!known) return known.error();
  if (!*known) {
    // The first to look after the machine started. Another process may do the same: one of the two changes
    // the row.
    SKYQUILT_TRY_ASSIGN(Statement update,
                        db.Prepare("UPDATE age_clock SET boot_id=?1, since_boot_us=?2 WHERE boot_id<>?1"));
    SKYQUILT_TRY(update.Bind(1, MachineBoot::Id()).Bind(2, MachineBoot::Elapsed().count()).Run());
    known = read();
    if (!known) return known.error();
    if (!*known) return Error{ErrorCode::kCorrupt, "The catalogue has lost its clock. Restore it.", ""};
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
  SKYQUILT_TRY_ASSIGN(
      Statement update,
      db.Prepare("UPDATE age_clock SET age_us=?1, since_boot_us=?2 WHERE boot_id=?3 AND age_us<?1"));
  return update.Bind(1, at_boot_us_ + elapsed.count())
      .Bind(2, elapsed.count())
      .Bind(3, MachineBoot::Id())
      .Run();
}

}  // namespace skyquilt::storage
