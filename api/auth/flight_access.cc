#include "api/auth/flight_access.h"

#include <algorithm>

#include "api/auth/access.h"
#include "api/common/node_answers.h"
#include "api/http/responses.h"
#include "core/base/try.h"
#include "core/flight/remarks/because.h"

namespace skyquilt::api {
namespace {

// What a token for one flight opens besides addresses that name its flight: documents without one, and lists,
// whose handlers leave the others out.
constexpr std::string_view kOpenToOneFlight[] = {"/api/v1/access",
                                                 "/api/v1/flights",
                                                 "/api/v1/jobs",
                                                 "/api/v1/jobs/{job}",
                                                 "/api/v1/jobs/{job}/log",
                                                 "/api/v1/events",
                                                 "/tiles/{tileset}",
                                                 "/tms",
                                                 "/tms/1.0.0",
                                                 "/arcgis/rest/info",
                                                 "/arcgis/rest/services",
                                                 "/tiles/index.json",
                                                 "/wmts",
                                                 "/wmts/1.0.0/WMTSCapabilities.xml",
                                                 "/wms",
                                                 "/stac",
                                                 "/stac/conformance",
                                                 "/stac/collections",
                                                 "/stac/collections/flights",
                                                 "/stac/collections/flights/items",
                                                 "/stac/collections/flights/items/{item}",
                                                 "/stac/search",
                                                 "/ogc",
                                                 "/ogc/conformance",
                                                 "/ogc/tileMatrixSets",
                                                 "/ogc/tileMatrixSets/{set}",
                                                 "/ogc/collections",
                                                 "/ogc/jobs/{job}",
                                                 "/ogc/jobs/{job}/results"};

std::optional<std::string> ParameterOf(const Request& request, std::string_view name) {
  for (const auto& [known, value] : request.parameters) {
    if (known == name) return value;
  }
  return std::nullopt;
}

// The flight that an address is about; none where it names none, or nothing that is there.
Result<std::optional<std::string>> FlightOf(Service& service, const Request& request) {
  // "ID.photos" is a collection of the flight (api/ogc).
  if (const auto flight = ParameterOf(request, "flight"))
    return std::optional(flight->substr(0, flight->find('.')));
  // "ID-r3" is its map as an item (api/stac).
  if (const auto item = ParameterOf(request, "item")) return std::optional(item->substr(0, item->find('-')));
  if (const auto tileset = ParameterOf(request, "tileset")) {
    return std::optional(tileset->substr(0, tileset->find('.')));
  }
  if (const auto job = ParameterOf(request, "job")) {
    const Result<storage::Job> found = service.queue.Get(*job);
    if (found) return std::optional(found->flight_id);
    if (found.error().code != ErrorCode::kNotFound) return found.error();
  }
  if (const auto uuid = ParameterOf(request, "uuid")) {
    const std::optional<std::string> usual = NodeUuid(*uuid);
    if (!usual) return std::optional<std::string>();
    const Result<storage::NodeTask> found = service.node_tasks.Find(*usual);
    if (found) return std::optional(found->flight_id);
    if (found.error().code != ErrorCode::kNotFound) return found.error();
  }
  return std::optional<std::string>();
}

bool IsOpenToOneFlight(const Request& request, std::string_view pattern,
                       const std::optional<std::string>& flight) {
  const bool is_listed = std::find(std::begin(kOpenToOneFlight), std::end(kOpenToOneFlight), pattern) !=
                         std::end(kOpenToOneFlight);
  if (!is_listed && pattern.find("{flight}") == std::string_view::npos) return false;
  return !flight || *flight == request.only_flight;
}

}  // namespace

bool MayChange(const Request& request, const std::string& owner) {
  return request.is_admin ||
         (!request.owner.empty() && request.only_flight.empty() && owner == request.owner);
}

Result<void> CheckMayChange(Service& service, const Request& request, const std::string& flight_id) {
  if (request.is_admin) return {};
  SKYQUILT_TRY_ASSIGN(const std::string owner, service.catalogue.OwnerOf(flight_id));
  if (MayChange(request, owner)) return {};
  return flight::Because(ErrorCode::kForbidden, flight::RemarkCode::kFailOfAnotherToken);
}

std::optional<Response> CheckFlightAccess(Service& service, const Request& request, const Route& route) {
  if (request.is_admin) return std::nullopt;
  if (!route.scope) return std::nullopt;
  const bool changes = *route.scope >= storage::Scope::kUpload;
  if (!changes && request.only_flight.empty()) return std::nullopt;
  const auto refuse = [&](const Error& error) {
    return IsNode(route.pattern) ? NodeProblem(error, request) : Problem(error, request);
  };
  const Result<std::optional<std::string>> flight = FlightOf(service, request);
  if (!flight) return refuse(flight.error());
  if (!request.only_flight.empty() && !IsOpenToOneFlight(request, route.pattern, *flight)) {
    return refuse({ErrorCode::kNotFound, "This token opens one flight, and there is nothing of it here."});
  }
  if (!changes || !*flight) return std::nullopt;
  const Result<void> may = CheckMayChange(service, request, **flight);
  if (may || may.error().code == ErrorCode::kNotFound) return std::nullopt;
  return refuse(may.error());
}

Result<storage::FlightPage> ListVisibleFlights(Service& service, const Request& request, int limit,
                                               const std::optional<std::string>& cursor,
                                               const std::optional<std::string>& tag) {
  if (request.only_flight.empty()) return service.catalogue.ListFlights(limit, cursor, tag);
  storage::FlightPage page;
  if (cursor) return page;
  Result<storage::Flight> flight = service.catalogue.GetFlight(request.only_flight);
  if (flight) {
    const std::vector<std::string>& tags = flight->tags;
    const bool is_asked_for = !tag || std::find(tags.begin(), tags.end(), *tag) != tags.end();
    if (is_asked_for) page.flights.push_back(*std::move(flight));
  } else if (flight.error().code != ErrorCode::kNotFound) {
    return flight.error();
  }
  return page;
}

Result<storage::MapPage> ListVisibleMaps(Service& service, const Request& request, int limit,
                                         const std::optional<std::string>& cursor) {
  if (request.only_flight.empty()) return service.catalogue.ListMaps(limit, cursor);
  storage::MapPage page;
  SKYQUILT_TRY_ASSIGN(const storage::FlightPage flights, ListVisibleFlights(service, request, 1, cursor));
  for (const storage::Flight& flight : flights.flights) {
    SKYQUILT_TRY_ASSIGN(const std::optional<storage::Revision> revision,
                        service.catalogue.ActiveRevision(flight.id));
    if (revision) page.maps.push_back({flight.id, flight.name, *revision, flight.tags});
  }
  return page;
}

}  // namespace skyquilt::api
