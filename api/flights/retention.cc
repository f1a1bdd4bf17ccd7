#include "api/flights/retention.h"

#include <chrono>
#include <vector>

#include "core/base/try.h"

namespace skyquilt::api {

Result<void> TrashIdleFlights(Service& service, const std::function<void(const storage::IdleFlight&)>& tell) {
  if (service.keep_days == 0) return service.idle_flights.Forget();
  if (service.trash_days == 0) {
    return Error{ErrorCode::kUnprocessable, "This server keeps no trash for flights that nobody changes.",
                 ""};
  }
  const std::chrono::days keep(service.keep_days);
  const storage::Time age = service.db.ages().Now();
  const storage::Time now = storage::Now();
  SKYQUILT_TRY_ASSIGN(const std::vector<storage::IdleFlight> idle, service.idle_flights.Look(age, now, keep));
  for (const storage::IdleFlight& flight : idle) {
    const auto still_idle = [&](storage::SqlConnection& db) {
      return storage::IdleFlights::IsIdle(db, flight.id, age, now, keep);
    };
    SKYQUILT_TRY_ASSIGN(const bool is_put,
                        service.db.Free([&] { return service.trash.PutIf(flight.id, now, still_idle); }));
    if (!is_put) continue;
    service.tilesets.Forget(flight.id);
    tell(flight);
  }
  return {};
}

}  // namespace skyquilt::api
