#include "api/shares/open_network.h"

#include "api/http/problem.h"
#include "api/http/responses.h"
#include "api/json/json_codec.h"

namespace skyquilt::api {
namespace {

Response OpenNetwork(Service& service, const Request& request) {
  if (!request.is_from_this_machine) {
    return Problem(
        {ErrorCode::kForbidden,
         "Whether this network sees the server is decided at its own machine: open the page there.", ""},
        request);
  }
  if (!service.open_network) {
    return Problem({ErrorCode::kConflict, "How others reach this server was said when it was started.", ""},
                   request);
  }
  const Result<void> opened = service.open_network();
  if (!opened) return Problem(opened.error(), request);
  std::vector<std::string> addresses;
  for (const std::string& address : service.addresses_for_others()) addresses.push_back(JsonString(address));
  return Json(200, JsonObject({{"addresses", JsonArray(addresses)}}));
}

}  // namespace

bool MayOpenNetwork(const Service& service, const Request& request) {
  return service.open_network != nullptr && request.is_from_this_machine && request.is_admin;
}

void AddNetworkRoute(Router& router, Service& service) {
  router
      .AddUpload(Method::kPost, "/api/v1/network",
                 [&](const Request& request) -> std::variant<std::unique_ptr<BodySink>, Response> {
                   return CollectBody(
                       [&service, request](const std::string&) { return OpenNetwork(service, request); });
                 })
      .scope = storage::Scope::kAdmin;
}

}  // namespace skyquilt::api
