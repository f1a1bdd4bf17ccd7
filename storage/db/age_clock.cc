#include "storage/db/age_clock.h"

#include <optional>

#include "core/base/try.h"
#include "storage/db/machine_boot.h"

namespace skyquilt::storage {

Result<AgeClock> AgeClock::Open(SqliteDb& db) {
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

Time AgeClock::Now() const { return at_boot_ + MachineBoot::Elapsed(); }

Result<void> AgeClock::Save(SqliteDb& db) const {
  const std::chrono::microseconds elapsed = MachineBoot::Elapsed();
  SKYQUILT_TRY_ASSIGN(
      Statement update,
      db.Prepare("UPDATE age_clock SET age_us=?1, since_boot_us=?2 WHERE boot_id=?3 AND age_us<?1"));
  return update.Bind(1, ToUs(at_boot_ + elapsed)).Bind(2, elapsed.count()).Bind(3, MachineBoot::Id()).Run();
}

}  // namespace skyquilt::storage
