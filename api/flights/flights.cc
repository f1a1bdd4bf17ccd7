#include "api/flights/flights.h"

#include <nlohmann/json.hpp>

#include "api/auth/flight_access.h"
#include "api/flights/trash.h"
#include "api/http/links.h"
#include "api/http/parameters.h"
#include "api/http/responses.h"
#include "api/routes.h"
#include "core/base/try.h"
#include "storage/tags/flight_tags.h"

namespace skyquilt::api {
namespace {

constexpr int kDefaultPage = 50;
constexpr int kLargestPage = 500;  // the page lists hundreds of flights by one request

Result<FlightView> WithJobAndMap(Service& service, storage::Flight flight) {
  FlightView view;
  SKYQUILT_TRY_ASSIGN(std::optional<storage::Job> job, service.queue.LatestOf(flight.id));
  view.job = std::move(job);
  SKYQUILT_TRY_ASSIGN(view.revision, service.catalogue.ActiveRevision(flight.id));
  if (!view.revision) {
    SKYQUILT_TRY_ASSIGN(std::optional<storage::Preview> preview,
                        storage::Previews(service.db).Find(flight.id));
    view.preview = std::move(preview);
  }
  view.flight = std::move(flight);
  return view;
}

Result<Response> ListFlights(Service& service, const Request& request) {
  SKYQUILT_TRY_ASSIGN(const int limit, PageSizeOf(request, kDefaultPage, kLargestPage));
  SKYQUILT_TRY_ASSIGN(const auto cursor, ParseCursor(request.Query("cursor")));
  std::optional<std::string> tag;
  if (const auto given = request.Query("tag")) {
    const auto checked = storage::CheckedTags({std::string(*given)});
    if (!checked) {
      return Error{ErrorCode::kInvalidArgument, "The parameter \"tag\": " + checked.error().message};
    }
    tag = checked->front();
  }
  SKYQUILT_TRY_ASSIGN(storage::FlightPage page, ListVisibleFlights(service, request, limit, cursor, tag));
  nlohmann::ordered_json flights = nlohmann::ordered_json::array();
  const storage::Time now = storage::Now();
  for (storage::Flight& flight : page.flights) {
    SKYQUILT_TRY_ASSIGN(FlightView view, WithJobAndMap(service, std::move(flight)));
    view.may_change = MayChange(request, view.flight.owner);
    view.base_path = request.base_path;
    flights.push_back(FlightJson(view, now));
  }
  nlohmann::ordered_json next_cursor;
  if (page.next_cursor) next_cursor = *page.next_cursor;
  Response response = JsonOf(200, {{"flights", std::move(flights)}, {"next_cursor", next_cursor}});
  if (page.next_cursor) {
    response.headers.Add("Link", "</api/v1/flights?limit=" + std::to_string(limit) +
                                     (tag ? "&tag=" + EncodedForQuery(*tag) : std::string()) +
                                     "&cursor=" + *page.next_cursor + ">; rel=\"next\"");
  }
  return response;
}

Result<Response> GetFlight(Service& service, const Request& request) {
  SKYQUILT_TRY_ASSIGN(FlightView view, ViewFlight(service, request.Parameter("flight")));
  view.may_change = MayChange(request, view.flight.owner);
  view.base_path = request.base_path;
  return JsonOf(200, FlightJson(view, storage::Now()));
}

Result<Response> Patch(Service& service, const Request& request, const std::string& body) {
  const std::string& id = request.Parameter("flight");
  SKYQUILT_TRY_ASSIGN(const storage::FlightChange fields, ParseFlightFields(body));
  if (fields.IsAny()) {
    SKYQUILT_TRY(service.catalogue.ChangeFlight(id, fields));
  }
  return GetFlight(service, request);
}

Result<Response> DeleteFlight(Service& service, const Request& request) {
  SKYQUILT_TRY(DeleteFlight(service, request.Parameter("flight")));
  return NoContent();
}

Result<Response> Verdict(Service& service, const Request& request) {
  const std::string& id = request.Parameter("flight");
  SKYQUILT_TRY_ASSIGN(const FlightView view, ViewFlight(service, id));
  if (!service.inspect) {
    return Error{ErrorCode::kUnavailable, "This server gives no verdicts."};
  }
  SKYQUILT_TRY_ASSIGN(const std::vector<storage::StoredFile> stored, service.catalogue.ListFiles(id));
  SKYQUILT_TRY_ASSIGN(const std::vector<storage::LocalBlob> fetched, service.store.FetchAll(id, stored));
  std::vector<flight::InputFile> files;
  for (std::size_t i = 0; i < stored.size(); ++i) files.push_back({stored[i].name, fetched[i].path});
  SKYQUILT_TRY_ASSIGN(std::string verdict, service.inspect(files, view.flight.options));
  return Json(200, std::move(verdict));
}

}  // namespace

std::string DefaultFlightName(storage::Time now) {
  std::string time = FormatTime(now).substr(0, 16);
  time[10] = ' ';
  return "Flight of " + time;
}

Result<FlightView> ViewFlight(Service& service, const std::string& id) {
  SKYQUILT_TRY(CheckId(id, "flight"));
  SKYQUILT_TRY_ASSIGN(storage::Flight flight, service.catalogue.GetFlight(id));
  return WithJobAndMap(service, std::move(flight));
}

void AddFlightRoutes(Router& router, Service& service) {
  router.Add(Method::kGet, "/api/v1/flights", On(service, ListFlights));
  router.Add(Method::kGet, "/api/v1/flights/{flight}", On(service, GetFlight));
  router.Add(Method::kDelete, "/api/v1/flights/{flight}",
             [&](const Request& r) { return DeleteFlight(service, r); });
  router.AddBody(
      Method::kPatch, "/api/v1/flights/{flight}", On(service, Patch),
      "Send the change as JSON with its header: curl -H 'Content-Type: application/json' -d '{}' ...");
}

void AddVerdictRoute(Router& router, Service& service) {
  router.AddCompute(Method::kGet, "/api/v1/flights/{flight}/verdict", On(service, Verdict));
}

}  // namespace skyquilt::api
