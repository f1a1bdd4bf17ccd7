// Flights: create, list, read, rename, delete. Creating one may bring its files along (api/uploads).
#pragma once

#include "api/json/json_codec.h"
#include "api/service.h"

namespace skyquilt::api {

// The flight with its latest job and the map it shows. Errors: kNotFound and the catalogue's.
Result<FlightView> ViewFlight(Service& service, const std::string& id);

// "Flight of 2026-11-21 04:55" for whoever gave no name.
std::string DefaultFlightName(storage::Time now);

}  // namespace skyquilt::api
