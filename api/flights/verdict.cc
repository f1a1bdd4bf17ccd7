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
  const Result<std::vector<storage::LocalBlob>> fetched = service.store.FetchAll(id, *stored);
  if (!fetched) return Problem(fetched.error(), request);
  std::vector<flight::InputFile> files;
  for (std::size_t i = 0; i < stored->size(); ++i) files.push_back({(*stored)[i].name, (*fetched)[i].path});
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
