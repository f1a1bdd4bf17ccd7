// Deleting flights: into the trash, out of it, and permanently.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "api/service.h"
#include "storage/retention/idle_flights.h"

namespace skyquilt::api {

// What a user's wish to delete means here: the flight goes to the trash, or for good where the server keeps
// none. Errors: kNotFound and the catalogue's.
Result<void> DeleteFlight(Service& service, const std::string& id);

// The flight with all that is on the disk, at once. `trashed_until`: as Catalogue::DeleteFlight. Errors: as
// above, and those of the store of photos and maps, with which the flight stays.
Result<void> RemoveFlight(Service& service, const std::string& id,
                          std::optional<storage::Time> trashed_until = std::nullopt);

// What has been in the trash for its days is removed; answers how many. Any thread.
Result<int> RemoveOldTrash(Service& service);

// Flights in which nothing has changed for as many days as the server keeps such go to the trash, as if
// somebody had deleted them there. Never for good. `tell` is called with each flight that is in the trash
// now. With Service::keep_days 0 none goes, and days begin anew once that changes. Errors: kUnprocessable
// (the server keeps no trash; nothing was done), and the catalogue's. Any thread.
Result<void> TrashIdleFlights(Service& service, const std::function<void(const storage::IdleFlight&)>& tell);

}  // namespace skyquilt::api
