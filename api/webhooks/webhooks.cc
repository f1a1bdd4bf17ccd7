#include "api/webhooks/webhooks.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "api/auth/access.h"
#include "api/http/responses.h"
#include "api/json/json_codec.h"
#include "api/json/json_text.h"
#include "api/routes.h"
#include "core/base/text/json_io.h"
#include "core/base/try.h"
#include "storage/blobs/sha256.h"
#include "storage/catalogue/webhooks.h"

namespace skyquilt::api {
namespace {

constexpr std::size_t kLongestUrl = 2000;
constexpr std::size_t kShortestSecret = 16;

struct NewWebhook {
  std::string url;
  std::string secret;
};

Result<NewWebhook> ParseNewWebhook(const std::string& body) {
  SKYQUILT_TRY(CheckJsonText(body));
  const auto parsed = ParseJson(body);
  if (!parsed.is_object()) return Error{ErrorCode::kInvalidArgument, "Send {\"url\": \"https://...\"}."};
  NewWebhook wanted;
  for (const auto& [field, value] : parsed.items()) {
    if ((field != "url" && field != "secret") || !value.is_string()) {
      return Error{ErrorCode::kUnprocessable,
                   "A webhook has a \"url\" and may have a \"secret\", both texts."};
    }
    (field == "url" ? wanted.url : wanted.secret) = value.get<std::string>();
  }
  SKYQUILT_TRY(CheckWebhookUrl(wanted.url));
  if (!wanted.secret.empty() && wanted.secret.size() < kShortestSecret) {
    return Error{ErrorCode::kUnprocessable, "The \"secret\" must have 16 characters or more."};
  }
  if (wanted.secret.empty()) wanted.secret = NewTokenText();
  return wanted;
}

nlohmann::ordered_json Described(const storage::Webhook& webhook, bool with_secret) {
  nlohmann::ordered_json described = {
      {"id", webhook.id}, {"url", webhook.url}, {"created_at", FormatTime(webhook.created)}};
  if (with_secret) described["secret"] = webhook.secret;
  return described;
}

Result<Response> AddWebhook(Service& service, const Request&, const std::string& body) {
  if (!service.sends_webhooks) {
    return Error{ErrorCode::kForbidden,
                 "This server speaks to nobody by itself; serve --webhooks changes that."};
  }
  SKYQUILT_TRY_ASSIGN(const NewWebhook wanted, ParseNewWebhook(body));
  SKYQUILT_TRY(service.check_receiver(wanted.url));
  SKYQUILT_TRY_ASSIGN(const storage::Webhook made,
                      storage::Webhooks(service.db).Add(wanted.url, wanted.secret, storage::Now()));
  return JsonOf(201, Described(made, true));
}

Result<Response> ListWebhooks(storage::CatalogueDb& db, const Request&) {
  SKYQUILT_TRY_ASSIGN(const std::vector<storage::Webhook> list, storage::Webhooks(db).List());
  nlohmann::ordered_json items = nlohmann::ordered_json::array();
  for (const storage::Webhook& webhook : list) items.push_back(Described(webhook, false));
  return JsonOf(200, {{"webhooks", items}});
}

Result<Response> RemoveWebhook(storage::CatalogueDb& db, const Request& request) {
  SKYQUILT_TRY(storage::Webhooks(db).Remove(request.Parameter("webhook")));
  return NoContent();
}

}  // namespace

Result<void> CheckWebhookUrl(std::string_view url) {
  const bool is_http = url.starts_with("http://") || url.starts_with("https://");
  for (const char c : url) {
    if (c <= ' ' || c == 0x7f || c == '@')
      return Error{ErrorCode::kUnprocessable, "This address cannot be used."};
  }
  if (!is_http || url.size() > kLongestUrl)
    return Error{ErrorCode::kUnprocessable, "The \"url\" must be an http or https address."};
  return {};
}

std::string WebhookSignature(const std::string& secret, std::int64_t at_s, const std::string& body) {
  const std::string mac = storage::HmacSha256(secret, fmt::format("{}.{}", at_s, body));
  return fmt::format("t={},v1={}", at_s, storage::HexOf(mac));
}

void AddWebhookRoutes(Router& router, Service& service) {
  using enum storage::Scope;
  const char* const one = "/api/v1/webhooks/{webhook}";
  router.Add(Method::kGet, "/api/v1/webhooks", On(service.db, ListWebhooks)).scope = kAdmin;
  router.AddBody(Method::kPost, "/api/v1/webhooks", On(service, AddWebhook)).scope = kAdmin;
  router.Add(Method::kDelete, one, On(service.db, RemoveWebhook)).scope = kAdmin;
}

}  // namespace skyquilt::api
