#include "storage/db/postgres/server_clock.h"

#include "core/base/try.h"
#include "storage/db/machine_boot.h"

namespace skyquilt::storage {
namespace {

constexpr std::chrono::seconds kGoodFor{30};
constexpr std::chrono::milliseconds kSet{200};    // a jump of this machine's clock
constexpr std::chrono::milliseconds kSmall{500};  // a difference that is none

}  // namespace

Result<ServerClock::Measured> ServerClock::Measure(SqlConnection& db) const {
  SKYQUILT_TRY_ASSIGN(Statement query, db.Prepare("SELECT now_us()"));
  const Time before = local_();
  SKYQUILT_TRY(query.Step());
  const Time after = local_();
  // The answer is true for some moment between the two.
  if (after - before > 2 * kSmall)
    return Error{ErrorCode::kUnavailable, "The catalogue's database answers too slowly to compare clocks.",
                 ""};
  const Time here = before + (after - before) / 2;
  Measured measured{FromUs(query.ColumnInt64(0)) - here, after, MachineBoot::Elapsed()};
  if (std::chrono::abs(measured.difference) < kSmall) measured.difference = std::chrono::microseconds(0);
  return measured;
}

Time ServerClock::At(Time here, SqlConnection& db) {
  const std::lock_guard lock(mutex_);
  const auto passed = MachineBoot::Elapsed() - measured_.elapsed;
  const auto shown = local_() - measured_.local;
  if (!was_measured_ || passed > kGoodFor || std::chrono::abs(shown - passed) > kSet) {
    if (const Result<Measured> measured = Measure(db)) {
      measured_ = *measured;
      was_measured_ = true;
    }
  }
  return here + measured_.difference;
}

}  // namespace skyquilt::storage
