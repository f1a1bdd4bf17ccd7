#include "api/flights/verdict.h"

#include "api/flights/flights.h"
#include "api/http/problem.h"
#include "api/http/responses.h"

namespace skyquilt::api {
namespace {

Response Verdict(Service& service, const Request& request) {
  const std::string& id = request.Parameter("flight");
  const Result<FlightView> view = ViewFlight(service, id);
  if (!view) return Problem(view.error(), request);
  if (!service.inspect) {
    return Problem({ErrorCode::kUnavailable, "This server gives no verdicts.", ""}, request);
  }
  const Result<std::vector<storage::StoredFile>> stored = service.catalogue.ListFiles(id);
  if (!stored) return Problem(stored.error(), request);
  std::vector<flight::InputFile> files;
  for (const storage::StoredFile& file : *stored) {
    files.push_back({file.name, service.store.PathOf(id, file.stored_name)});
  }
  Result<std::string> verdict = service.inspect(files, view->flight.options);
  if (!verdict) return Problem(verdict.error(), request);
  return Json(200, *std::move(verdict));
}

}  // namespace

void AddVerdictRoute(Router& router, Service& service) {
  router.AddCompute(Method::kGet, "/api/v1/flights/{flight}/verdict",
                    [&](const Request& request) { return Verdict(service, request); });
}

}  // namespace skyquilt::api
