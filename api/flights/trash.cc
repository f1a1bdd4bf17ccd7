#include "api/flights/trash.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "api/auth/flight_access.h"
#include "api/flights/flights.h"
#include "api/http/responses.h"
#include "api/json/json_codec.h"
#include "api/routes.h"
#include "core/base/try.h"
#include "storage/blobs/blob_store.h"
#include "storage/catalogue/trash.h"

namespace skyquilt::api {
namespace {

storage::Trash TrashOf(Service& service) {
  return storage::Trash(service.db, storage::FlightRecords(service.store.dir()));
}

// Whether photos or maps of a flight may lie in their store.
Result<bool> HasHadAnything(const Service& service, const std::string& id) {
  SKYQUILT_TRY_ASSIGN(const std::vector<storage::StoredFile> files, service.catalogue.ListFiles(id));
  SKYQUILT_TRY_ASSIGN(const std::int64_t next, service.catalogue.NextRevision(id));
  return !files.empty() || next > 1;
}

nlohmann::ordered_json TrashedJson(const Service& service, const storage::TrashedFlight& flight) {
  const storage::AgeClock& ages = service.db.ages();
  const storage::Time end = flight.deleted_age + std::chrono::days(service.trash_days);
  const double days = std::chrono::duration<double, std::ratio<86400>>(end - ages.Now()).count();
  const auto days_left = static_cast<int>(std::ceil(std::clamp(days, 0.0, 1.0 * service.trash_days)));
  return {{"id", flight.id},
          {"name", flight.name},
          {"created_at", FormatTime(flight.created)},
          {"file_count", flight.file_count},
          {"bytes", flight.bytes},
          {"deleted_at", FormatTime(flight.deleted)},
          {"removed_at", FormatTime(ages.OnTheWall(end))},
          {"days_left", days_left}};
}

Result<Response> ListTrash(Service& service, const Request& request) {
  SKYQUILT_TRY_ASSIGN(const std::vector<storage::TrashedFlight> flights, TrashOf(service).List());
  nlohmann::ordered_json items = nlohmann::ordered_json::array();
  for (const storage::TrashedFlight& flight : flights) {
    // What was deleted is seen by whoever may take it back.
    if (MayChange(request, flight.owner)) items.push_back(TrashedJson(service, flight));
  }
  return JsonOf(200, {{"days", service.trash_days}, {"flights", items}});
}

Result<Response> Restore(Service& service, const Request& request) {
  const std::string& id = request.Parameter("flight");
  SKYQUILT_TRY(CheckId(id, "flight"));
  SKYQUILT_TRY(TrashOf(service).Restore(id));
  SKYQUILT_TRY_ASSIGN(FlightView view, ViewFlight(service, id));
  view.may_change = MayChange(request, view.flight.owner);
  view.base_path = request.base_path;
  return JsonOf(200, FlightJson(view, storage::Now()));
}

Result<Response> RemoveForGood(Service& service, const Request& request) {
  const std::string& id = request.Parameter("flight");
  SKYQUILT_TRY(CheckId(id, "flight"));
  // Only what was deleted before: nobody loses a flight by one slip.
  SKYQUILT_TRY(TrashOf(service).Find(id));
  SKYQUILT_TRY(RemoveFlight(service, id, storage::Time::max()));
  return NoContent();
}

}  // namespace

Result<void> DeleteFlight(Service& service, const std::string& id) {
  if (service.trash_days == 0) return RemoveFlight(service, id);
  SKYQUILT_TRY(service.db.Free([&] { return TrashOf(service).Put(id, storage::Now()); }));
  service.tilesets.Forget(id);
  return {};
}

Result<void> RemoveFlight(Service& service, const std::string& id,
                          std::optional<storage::Time> trashed_until) {
  // What they have made waits for their next attempts; without them nobody could tell whose it was.
  SKYQUILT_TRY_ASSIGN(const std::vector<std::string> jobs, service.queue.JobsOf(id));
  // A store that hears nothing of it would keep all of the flight for ever. One of which it never took
  // anything (an upload that failed) need not wait for it.
  storage::BlobStore& blobs = service.store.blobs();
  bool is_marked = false;
  if (!blobs.IsFolder()) {
    SKYQUILT_TRY_ASSIGN(const bool has_had_anything, HasHadAnything(service, id));
    if (has_had_anything) {
      SKYQUILT_TRY_ASSIGN(is_marked, storage::MarkDeleted(blobs, id));
    }
  }
  // The catalogue first: what is then left on the disk is garbage that any start-up removes.
  const Result<void> deleted =
      service.db.Free([&] { return service.catalogue.DeleteFlight(id, trashed_until); });
  if (!deleted && is_marked && service.catalogue.OwnerOf(id))  // it stays
    (void)blobs.Remove(std::string(storage::kDeletedPrefix) + id).ok();
  if (!deleted) return deleted;
  service.tilesets.Forget(id);
  service.store.RemoveFlight(id, jobs);
  service.db.FillReserve();
  return {};
}

Result<int> RemoveOldTrash(Service& service) {
  const storage::Time until = service.db.ages().Now() - std::chrono::days(service.trash_days);
  SKYQUILT_TRY_ASSIGN(const auto old, TrashOf(service).DeletedUntil(until));
  int removed = 0;
  for (const std::string& id : old) {
    const Result<void> done = RemoveFlight(service, id, until);
    // One that was restored or removed a moment ago needs nothing more.
    if (!done && done.error().code != ErrorCode::kNotFound) return done.error();
    removed += done ? 1 : 0;
  }
  return removed;
}

void AddTrashRoutes(Router& router, Service& service) {
  router.Add(Method::kGet, "/api/v1/trash", On(service, ListTrash));
  router.Add(Method::kDelete, "/api/v1/trash/{flight}", On(service, RemoveForGood));
  router.AddBody(Method::kPost, "/api/v1/flights/{flight}/restore",
                 [&](const Request& request, const std::string&) { return Restore(service, request); });
}

Result<void> TrashIdleFlights(Service& service, const std::function<void(const storage::IdleFlight&)>& tell) {
  storage::IdleFlights idle_flights(service.db);
  if (service.keep_days == 0) return idle_flights.Forget();
  if (service.trash_days == 0) {
    return Error{ErrorCode::kUnprocessable, "This server keeps no trash for flights that nobody changes."};
  }
  const std::chrono::days keep(service.keep_days);
  const storage::Time age = service.db.ages().Now();
  const storage::Time now = storage::Now();
  SKYQUILT_TRY_ASSIGN(const std::vector<storage::IdleFlight> idle, idle_flights.Look(age, now, keep));
  for (const storage::IdleFlight& flight : idle) {
    const auto still_idle = [&](storage::SqlConnection& db) {
      return storage::IdleFlights::IsIdle(db, flight.id, age, now, keep);
    };
    SKYQUILT_TRY_ASSIGN(const bool is_put,
                        service.db.Free([&] { return TrashOf(service).PutIf(flight.id, now, still_idle); }));
    if (!is_put) continue;
    service.tilesets.Forget(flight.id);
    tell(flight);
  }
  return {};
}

}  // namespace skyquilt::api
