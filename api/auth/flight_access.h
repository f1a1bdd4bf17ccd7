// Which flights a request may be about. A flight belongs to the token that made it: another token of scope
// upload may read it and change nothing; one of scope admin may change all flights. A token for one flight
// reads that flight and cannot see others. Where the server requires no token, everybody is an admin. Reads
// the catalogue: not for threads that serve sockets. Errors: kForbidden (another owner's), kNotFound, and the
// catalogue's.
#pragma once

#include <optional>
#include <string>

#include "api/http/router.h"
#include "api/service.h"

namespace skyquilt::api {

// `owner`: id of the token that made the flight; empty without one.
bool MayChange(const Request& request, const std::string& owner);
// For handlers whose flight stands in a body or a header.
Result<void> CheckMayChange(Service& service, const Request& request, const std::string& flight_id);

// For every route: the refusal, where the flight that the address names, or the job or task of one, is not
// for who asks. An address that names nothing we have passes: its handler says so.
std::optional<Response> CheckFlightAccess(Service& service, const Request& request, const Route& route);

// The flights that the requester may know of, as Catalogue::ListFlights.
Result<storage::FlightPage> ListVisibleFlights(Service& service, const Request& request, int limit,
                                               const std::optional<std::string>& cursor,
                                               const std::optional<std::string>& tag = std::nullopt);
// Of these, those that show a map, as Catalogue::ListMaps.
Result<storage::MapPage> ListVisibleMaps(Service& service, const Request& request, int limit,
                                         const std::optional<std::string>& cursor);

}  // namespace skyquilt::api
