// Shares: tokens that open one flight for reading, made and revoked by whoever may change the flight. GET and
// POST /api/v1/flights/{flight}/shares, DELETE .../shares/{share}. The token is shown once, when it is made;
// it only reads also where the server asks nobody for one. And what links need that are handed to others: a
// server that listens to its own machine alone, seen by the network for as long as it runs. Asked by who sits
// at that machine, and by nobody else. Whoever comes by those addresses needs a token (api/auth/access), so
// that links read and nobody writes who could not before.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "api/auth/access.h"
#include "api/common/find_flight.h"
#include "api/http/responses.h"
#include "api/json/json_codec.h"
#include "api/json/json_text.h"
#include "api/routes.h"
#include "core/base/text/json_io.h"
#include "core/base/try.h"
#include "storage/db/ids.h"

namespace skyquilt::api {
namespace {

constexpr int kMaxDays = 3650;
constexpr int kUsualDays = 30;
constexpr std::size_t kMaxShares = 100;  // of one flight; each request reads all tokens

// Days until the share ends; absent: never.
Result<std::optional<int>> ParseDays(const std::string& body) {
  if (body.find_first_not_of(" \t\r\n") == std::string::npos) return std::optional<int>(kUsualDays);
  SKYQUILT_TRY(CheckJsonText(body));
  const auto parsed = ParseJson(body);
  if (!parsed.is_object()) return Error{ErrorCode::kInvalidArgument, "Send {\"expires_in_days\": 30}."};
  std::optional<int> days = kUsualDays;
  for (const auto& [field, value] : parsed.items()) {
    if (field != "expires_in_days") {
      return Error{ErrorCode::kUnprocessable, fmt::format("The field \"{}\" is not known.", field)};
    }
    const bool is_fit = value.is_null() || (value.is_number_integer() && value >= 1 && value <= kMaxDays);
    if (!is_fit) {
      return Error{
          ErrorCode::kUnprocessable,
          fmt::format(
              "The field \"expires_in_days\" must be a whole number from 1 to {}, or null for a share "
              "that never ends.",
              kMaxDays)};
    }
    days = value.is_null() ? std::nullopt : std::optional(value.get<int>());
  }
  return days;
}

nlohmann::ordered_json Described(const storage::Token& token) {
  nlohmann::ordered_json described = {
      {"id", token.id}, {"created_at", FormatTime(token.created)}, {"expires_at", nullptr}};
  if (token.expires) described["expires_at"] = FormatTime(*token.expires);
  return described;
}

// Those that have not ended, newest first.
std::vector<storage::Token> SharesOf(const storage::TokenSet& set, const std::string& flight_id,
                                     storage::Time now) {
  std::vector<storage::Token> shares;
  for (auto token = set.tokens.rbegin(); token != set.tokens.rend(); ++token) {
    if (token->flight_id == flight_id && !token->HasEnded(now)) shares.push_back(*token);
  }
  return shares;
}

// Is that this request's to ask, and something that this server does?
bool MayOpenNetwork(const Service& service, const Request& request) {
  return service.open_network != nullptr && request.is_from_this_machine && request.is_admin;
}

Result<Response> ListShares(Service& service, const Request& request) {
  const std::string& flight_id = request.Parameter("flight");
  SKYQUILT_TRY(RequireFlight(service, flight_id));
  SKYQUILT_TRY_ASSIGN(const storage::TokenSet set, service.tokens.Read());
  nlohmann::ordered_json items = nlohmann::ordered_json::array();
  for (const storage::Token& share : SharesOf(set, flight_id, storage::Now())) {
    items.push_back(Described(share));
  }
  const bool needs_token = set.requires_token || service.is_network_open;
  return JsonOf(200, {{"needs_token", needs_token},
                      {"may_open_network", MayOpenNetwork(service, request)},
                      {"addresses", service.addresses_for_others(request.is_from_this_machine)},
                      {"shares", items}});
}

// Shares that have ended make room.
Result<void> MakeRoom(Service& service, const storage::TokenSet& set, const std::string& flight_id,
                      storage::Time now) {
  if (SharesOf(set, flight_id, now).size() >= kMaxShares) {
    return Error{ErrorCode::kConflict,
                 fmt::format("This flight has {} shares already. Revoke one first.", kMaxShares)};
  }
  for (const storage::Token& token : set.tokens) {
    if (token.flight_id != flight_id || !token.HasEnded(now)) continue;
    const Result<void> removed = service.tokens.RevokeShare(flight_id, token.id);
    // Another request may have been faster.
    if (!removed && removed.error().code != ErrorCode::kNotFound) return removed.error();
  }
  return {};
}

Result<Response> AddShare(Service& service, const Request& request, const std::string& body) {
  const std::string& flight_id = request.Parameter("flight");
  SKYQUILT_TRY(RequireFlight(service, flight_id));
  SKYQUILT_TRY_ASSIGN(const std::optional<int> days, ParseDays(body));
  SKYQUILT_TRY_ASSIGN(const storage::TokenSet set, service.tokens.Read());
  const storage::Time now = storage::Now();
  SKYQUILT_TRY(MakeRoom(service, set, flight_id, now));
  const std::string text = NewShareText();
  storage::Token token;
  token.id = storage::NewId();
  token.name = "share-" + token.id;
  token.hash = HashToken(text);
  token.created = now;
  if (days) token.expires = now + std::chrono::hours(24) * *days;
  token.flight_id = flight_id;
  SKYQUILT_TRY(service.tokens.AddShare(token));
  nlohmann::ordered_json made = Described(token);
  made["token"] = text;
  // Behind '#', so that no server or proxy on the way writes it down.
  made["page"] = fmt::format("{}/#/flights/{}?token={}", request.base_path, flight_id, text);
  made["embed"] = fmt::format("{}/embed/{}#token={}", request.base_path, flight_id, text);
  return JsonOf(201, made);
}

Result<Response> RemoveShare(Service& service, const Request& request) {
  SKYQUILT_TRY(service.tokens.RevokeShare(request.Parameter("flight"), request.Parameter("share")));
  return NoContent();
}

Result<Response> OpenNetwork(Service& service, const Request& request) {
  if (!request.is_from_this_machine) {
    return Error{ErrorCode::kForbidden,
                 "Whether this network sees the server is decided at its own machine: open the page there."};
  }
  if (!service.open_network) {
    return Error{ErrorCode::kConflict, "How others reach this server was said when it was started."};
  }
  SKYQUILT_TRY(service.open_network());
  return JsonOf(200, {{"addresses", service.addresses_for_others(request.is_from_this_machine)}});
}

}  // namespace

void AddShareRoutes(Router& router, Service& service) {
  router.Add(Method::kGet, "/api/v1/flights/{flight}/shares", On(service, ListShares)).scope =
      storage::Scope::kUpload;  // who may revoke them
  router.AddBody(
      Method::kPost, "/api/v1/flights/{flight}/shares", On(service, AddShare),
      "Send the wish as JSON with its header: curl -H 'Content-Type: application/json' -d '{}' ...");
  router.Add(Method::kDelete, "/api/v1/flights/{flight}/shares/{share}", On(service, RemoveShare));
}

void AddNetworkRoute(Router& router, Service& service) {
  router
      .AddBody(Method::kPost, "/api/v1/network",
               [&](const Request& request, const std::string&) { return OpenNetwork(service, request); })
      .scope = storage::Scope::kAdmin;
}

}  // namespace skyquilt::api
