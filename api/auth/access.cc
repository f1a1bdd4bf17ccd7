#include "api/auth/access.h"

#include <openssl/crypto.h>

#include <array>
#include <memory>
#include <nlohmann/json.hpp>

#include "api/auth/limits.h"
#include "api/common/node_answers.h"
#include "api/http/digest.h"
#include "api/http/parameters.h"
#include "api/http/responses.h"
#include "api/routes.h"
#include "core/base/try.h"
#include "storage/db/ids.h"

namespace skyquilt::api {
namespace {

using storage::Scope;

// How they begin.
constexpr std::string_view kTokenText = "sq_", kShareText = "sq_share_";

struct ShownToken {
  std::string text;
  bool is_in_query = false;
};

ShownToken ShownBy(const Request& request) {
  const std::string_view header = request.headers.Find("Authorization");
  constexpr std::string_view kBearer = "Bearer ";
  if (header.size() > kBearer.size() && EqualsIgnoringCase(header.substr(0, kBearer.size()), kBearer)) {
    return {std::string(header.substr(kBearer.size())), false};
  }
  if (!header.empty()) return {std::string(header), false};
  // In whatever case: GeoServer, which cascades a WMS, writes all names of an address in capitals.
  return {Parameter(request, "token").value_or(""), true};
}

// Every token is compared whole, whatever the outcome: the time taken tells nothing.
const storage::Token* Recognise(const storage::TokenSet& set, std::string_view text) {
  const std::string hash = HashToken(text);
  const storage::Token* found = nullptr;
  for (const storage::Token& token : set.tokens) {
    if (token.hash.size() == hash.size() && CRYPTO_memcmp(token.hash.data(), hash.data(), hash.size()) == 0) {
      found = &token;
    }
  }
  return found != nullptr && found->HasEnded(storage::Now()) ? nullptr : found;
}

Response Unauthorized(const Request& request, std::string_view pattern, bool has_live_token,
                      std::string_view shown) {
  if (IsNode(pattern)) {
    return NodeAnswer(
        R"({"error":"Invalid authentication token: the token does not match one that this node's operator made."})");
  }
  const char* how =
      shown.starts_with(kShareText) ? "This link has ended or was revoked. Ask whoever sent it for another."
      : has_live_token && !shown.empty()
          ? "The token that came with this request is not good here: it is mistyped, was revoked or has ended. The "
            "server's operator makes another with \"skyquilt token add\"."
      : request.needs_token
          ? "At this address the server shows what a link or a token opens. Ask whoever runs it for one."
      : has_live_token
          ? "This server asks for a token. Its operator makes one with \"skyquilt token add\"."
          : "This server asks for a token, and all that it had were revoked or have ended. Its operator makes one "
            "with \"skyquilt token add\", or starts it again with --open to let everybody in.";
  Response response = Problem({ErrorCode::kUnauthorized, how}, request);
  response.headers.Add("WWW-Authenticate", "Bearer realm=\"skyquilt\"");
  return response;
}

Response Forbidden(const Request& request, std::string_view pattern, Scope needed) {
  const Error error{ErrorCode::kForbidden, std::string("This token may not do that: it needs the scope \"") +
                                               storage::ScopeName(needed) + "\"."};
  return IsNode(pattern) ? NodeRefusal(error.message) : Problem(error, request);
}

std::string NewTextAfter(std::string_view beginning) {
  std::array<std::uint8_t, 32> random{};
  storage::FillWithRandom(random);
  std::string text = EncodeBase64({reinterpret_cast<const char*>(random.data()), random.size()});
  for (char& c : text) c = c == '+' ? '-' : c == '/' ? '_' : c;
  while (text.ends_with('=')) text.pop_back();
  return std::string(beginning) + text;
}

// What who asks may do here, so that a page offers nothing that would be refused.
Result<Response> OwnAccess(Service& service, const Request& request) {
  SKYQUILT_TRY_ASSIGN(const auto tokens, service.tokens.Known());
  storage::Scope scope = request.is_admin ? storage::Scope::kAdmin : storage::Scope::kRead;
  // What came in the address, or opens one flight, only reads (api/auth/access).
  const bool only_reads = !request.only_flight.empty() || !request.headers.Has("Authorization");
  for (const storage::Token& token : tokens->tokens) {
    if (!only_reads && token.id == request.owner) scope = token.scope;
  }
  nlohmann::ordered_json access;
  access["needs_token"] = tokens->requires_token || request.needs_token;
  access["scope"] = storage::ScopeName(scope);
  access["flight"] = nullptr;
  if (!request.only_flight.empty()) access["flight"] = request.only_flight;
  access["keep_days"] = service.keep_days;
  return JsonOf(200, access);
}

}  // namespace

bool IsNode(std::string_view pattern) {
  return pattern.starts_with("/task/") || pattern == "/info" || pattern == "/options";
}

std::optional<Response> CheckAccess(Service& service, Request& request, const Route& route) {
  if (!route.scope) return std::nullopt;
  const auto known = service.tokens.Known();
  if (!known) return Problem(known.error(), request);
  std::shared_ptr<const storage::TokenSet> tokens = *known;
  const ShownToken shown = ShownBy(request);
  const storage::Token* token = shown.text.empty() ? nullptr : Recognise(*tokens, shown.text);
  // A command may have made it since; what is no token of ours costs nobody a look.
  if (token == nullptr && shown.text.starts_with(kTokenText)) {
    if (const auto again = service.tokens.Known(storage::Tokens::kFreshForUnknown)) tokens = *again;
    token = Recognise(*tokens, shown.text);
  }
  const bool is_share = shown.text.starts_with(kShareText) || (token != nullptr && !token->flight_id.empty());
  if (!tokens->requires_token && !is_share && !request.needs_token) {
    request.is_admin = true;
    return std::nullopt;
  }
  if (token == nullptr)
    return Unauthorized(request, route.pattern, tokens->HasLiveOne(storage::Now()), shown.text);
  // What stands in an address gets into histories and logs of others: it opens nothing but reading.
  const bool only_reads = (shown.is_in_query && !IsNode(route.pattern)) || !token->flight_id.empty();
  const Scope granted = only_reads ? Scope::kRead : token->scope;
  if (granted < *route.scope) return Forbidden(request, route.pattern, *route.scope);
  request.owner = token->id;
  request.is_admin = granted == Scope::kAdmin;
  request.only_flight = token->flight_id;
  const Result<void> within = CheckLimits(service, *token);
  if (within) return std::nullopt;
  return IsNode(route.pattern) ? NodeRefusal(within.error().message) : Problem(within.error(), request);
}

void KeepToAsker(const Service& service, const Request& request, Response& response) {
  if (request.owner.empty() || response.wants) return;
  response.headers.AddVary("Authorization");
  constexpr std::string_view kPublic = "public";
  std::string control(response.headers.Find("Cache-Control"));
  if (control.starts_with(kPublic)) {
    if (service.has_keyed_cache) return;
    control.replace(0, kPublic.size(), "private");
  } else if (control.empty()) {
    control = "private, no-cache";
  } else if (!control.starts_with("private") && control != "no-store") {
    control.insert(0, "private, ");
  }
  response.headers.Set("Cache-Control", std::move(control));
}

bool IsStillGood(Service& service, const std::string& owner) {
  const auto tokens = service.tokens.Known();
  if (!tokens) return false;
  if (owner.empty()) return !(*tokens)->requires_token;
  for (const storage::Token& token : (*tokens)->tokens) {
    if (token.id == owner) return !token.HasEnded(storage::Now());
  }
  return false;
}

std::string NewTokenText() { return NewTextAfter(kTokenText); }

std::string NewShareText() { return NewTextAfter(kShareText); }

std::string HashToken(std::string_view text) { return RawDigestOf(DigestAlgorithm::kSha256, text); }

void AddOwnAccessRoute(Router& router, Service& service) {
  router.Add(Method::kGet, "/api/v1/access", On(service, OwnAccess));
}

}  // namespace skyquilt::api
