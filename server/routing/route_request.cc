#include "server/routing/route_request.h"

#include <fmt/format.h>

#include <optional>
#include <utility>

#include "api/http/responses.h"
#include "api/http/target.h"
#include "server/routing/client_address.h"
#include "server/routing/origin_policy.h"
#include "server/routing/public_address.h"

namespace skyquilt::server {
namespace {

std::optional<api::Method> MethodFrom(std::string_view name) {
  for (const api::Method method : {api::Method::kGet, api::Method::kPost, api::Method::kPut,
                                   api::Method::kPatch, api::Method::kDelete, api::Method::kOptions}) {
    if (name == api::MethodName(method)) return method;
  }
  return std::nullopt;
}

api::Response Options(const std::string& allow) {
  api::Response response;
  response.status = 204;
  response.headers.Add("Allow", allow);
  return response;
}

// The page's own addresses count from the slash.
api::Response ToBaseWithSlash(const std::string& target, const std::string& base_path) {
  api::Response response;
  response.status = 308;
  response.headers.Add("Location", base_path + "/" + target.substr(base_path.size()));
  return response;
}

// "/stac/" means "/stac": so people paste addresses, and programs put them together. Nothing where there is
// nothing without the slash either.
std::optional<api::Response> ToPathWithoutSlash(const std::string& target, const api::Router& router) {
  std::string path = PathOf(target);
  if (path.size() < 2 || path.back() != '/') return std::nullopt;
  const std::string query = target.substr(path.size());
  path.pop_back();
  const Result<api::Target> without = api::ParseTarget(path + query);
  if (!without) return std::nullopt;
  const api::Router::Match match = router.Find(api::Method::kGet, without->segments);
  if (match.route == nullptr || !match.route->pattern.starts_with('/'))
    return std::nullopt;  // the page's own
  api::Response response;
  response.status = 308;
  response.headers.Add("Location", path + query);
  return response;
}

}  // namespace

std::string PathOf(const std::string& target) { return target.substr(0, target.find('?')); }

Routed RouteRequest(RequestHead& head, const api::Router& router, const HttpSettings& settings,
                    api::Service& service, const std::string& request_id, const std::string& peer,
                    bool by_network) {
  Routed routed;
  const PublicAddress address = PublicAddressOf(head, peer, settings);
  routed.request.base_path = address.base_path;
  if (IsBaseWithoutSlash(head.target, settings.base_path)) {
    routed.response = ToBaseWithSlash(head.target, settings.base_path);
    return routed;
  }
  head.target = WithoutBasePath(head.target, settings.base_path);
  const std::string path = PathOf(head.target);
  const auto answer = [&](api::Response response) {
    routed.route = nullptr;
    routed.response = std::move(response);
    return std::move(routed);
  };
  const auto problem = [&](ErrorCode code, const char* message) {
    return api::Problem({code, message}, path, request_id);
  };
  const bool requires_token = service.tokens.RequiresToken() || by_network;
  if (!requires_token || settings.always_checks_host) {
    for (const std::string& host : {head.host, ForwardedHost(head, peer, settings)}) {
      if (host.empty() || IsOwnHost(host, settings)) continue;
      return answer(api::ProblemWithStatus(
          421,
          fmt::format("This server does not go by the name \"{}\". Its operator adds names with --host.",
                      host),
          path, request_id));
    }
  }
  routed.cors = CorsHeaders(head, settings, requires_token);
  if (head.target == "*") return answer(Options("GET, HEAD, POST, PUT, PATCH, DELETE, OPTIONS"));
  Result<api::Target> target = api::ParseTarget(head.target);
  if (!target && (head.method == "GET" || head.method == "HEAD")) {
    if (auto without = ToPathWithoutSlash(head.target, router)) return answer(*std::move(without));
  }
  if (!target) return answer(api::Problem(target.error(), path, request_id));
  const std::optional<api::Method> method = MethodFrom(head.method == "HEAD" ? "GET" : head.method);
  if (!method) return answer(problem(ErrorCode::kNotImplemented, "This method is not known here."));
  api::Router::Match match = router.Find(*method, target->segments);
  if (*method == api::Method::kOptions) AddPreflightHeaders(router.Allowed(target->segments), routed.cors);
  if (*method == api::Method::kOptions && match.route == nullptr) {
    const std::string allowed = router.Allowed(target->segments);
    return answer(allowed.empty() ? problem(ErrorCode::kNotFound, "There is nothing at this address.")
                                  : Options(allowed));
  }
  const bool changes = *method != api::Method::kGet && *method != api::Method::kOptions;
  if (changes && IsFromForeignPage(head, settings) &&
      !IsOriginAllowed(head.headers.Find("Origin"), settings, requires_token)) {
    return answer(problem(ErrorCode::kForbidden, "Pages of other sites may not change anything here."));
  }
  if (match.route == nullptr) {
    if (match.allow.empty())
      return answer(problem(ErrorCode::kNotFound, "There is nothing at this address."));
    // curl -T names the file itself behind a slash.
    const bool lacks_slash = *method == api::Method::kPut && path.ends_with("/files");
    api::Response response =
        problem(ErrorCode::kMethodNotAllowed,
                lacks_slash ? "End the address with a slash, behind which curl puts the file's name: curl -T "
                              "PHOTO.JPG .../files/"
                            : "This address does not take this method.");
    response.headers.Add("Allow", match.allow);
    return answer(std::move(response));
  }
  routed.route = match.route;
  routed.request.method = *method;
  routed.request.path = path;
  routed.request.parameters = std::move(match.parameters);
  routed.request.query = std::move(target->query);
  routed.request.content_length = head.content_length;
  routed.request.base_url = address.base_url;
  routed.request.request_id = request_id;
  routed.request.needs_token = by_network;
  routed.request.is_from_this_machine = !by_network && IsFromThisMachine(peer, head.headers);
  routed.request.headers = std::move(head.headers);
  // A range is of a GET's body alone (RFC 9110, 14.2).
  if (head.method == "HEAD") routed.request.headers.Remove("Range");
  return routed;
}

}  // namespace skyquilt::server
