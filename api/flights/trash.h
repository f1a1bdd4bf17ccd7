// Deleting flights: into the trash, out of it, and permanently.
#pragma once

#include <string>

#include "api/http/router.h"
#include "api/service.h"

namespace skyquilt::api {

// /api/v1/trash and /api/v1/flights/{flight}/restore
void AddTrashRoutes(Router& router, Service& service);

// What a user's wish to delete means here: the flight goes to the trash, or for good where the server keeps
// none. Errors: kNotFound and the catalogue's.
Result<void> DeleteFlight(Service& service, const std::string& id);

// The flight with all that is on the disk, at once. Errors: as above.
Result<void> RemoveFlight(Service& service, const std::string& id);

// What has been in the trash for its days is removed; answers how many. Any thread.
Result<int> RemoveOldTrash(Service& service);

}  // namespace skyquilt::api
