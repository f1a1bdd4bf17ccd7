// Flights in which nothing has changed for as many days as the server keeps such go to the trash, as if
// somebody had deleted them there. Never for good.
#pragma once

#include <functional>

#include "api/service.h"

namespace skyquilt::api {

// `tell` is called with each flight that is in the trash now. With Service::keep_days 0 none goes, and days
// begin anew once that changes. Errors: kUnprocessable (the server keeps no trash; nothing was done), and
// the catalogue's. Any thread.
Result<void> TrashIdleFlights(Service& service, const std::function<void(const storage::IdleFlight&)>& tell);

}  // namespace skyquilt::api
