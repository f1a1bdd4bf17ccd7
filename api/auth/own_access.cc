#include "api/auth/own_access.h"

#include "api/auth/access.h"
#include "api/http/problem.h"
#include "api/http/responses.h"
#include "api/json/json_codec.h"

namespace skyquilt::api {
namespace {

Response OwnAccess(Service& service, const Request& request) {
  const auto tokens = service.tokens.Known();
  if (!tokens) return Problem(tokens.error(), request);
  storage::Scope scope = request.is_admin ? storage::Scope::kAdmin : storage::Scope::kRead;
  // What came in the address, or opens one flight, only reads (api/auth/access).
  const bool only_reads = !request.only_flight.empty() || !request.headers.Has("Authorization");
  for (const storage::Token& token : (*tokens)->tokens) {
    if (!only_reads && token.id == request.owner) scope = token.scope;
  }
  return Json(
      200, JsonObject({{"needs_token", (*tokens)->requires_token || request.needs_token ? "true" : "false"},
                       {"scope", JsonString(storage::ScopeName(scope))},
                       {"flight",
                        request.only_flight.empty() ? std::string("null") : JsonString(request.only_flight)},
                       {"keep_days", std::to_string(service.keep_days)}}));
}

}  // namespace

void AddOwnAccessRoute(Router& router, Service& service) {
  router.Add(Method::kGet, "/api/v1/access", [&](const Request& r) { return OwnAccess(service, r); });
}

}  // namespace skyquilt::api
