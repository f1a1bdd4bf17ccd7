// Webhooks: addresses that the server notifies of ended jobs and new maps, where its operator allows outgoing
// requests at all (serve --webhooks). GET, POST and DELETE /api/v1/webhooks.
#pragma once

#include "api/service.h"

namespace skyquilt::api {

// kUnprocessable for an address that no message can go to.
Result<void> CheckWebhookUrl(std::string_view url);

// What a receiver checks: "t=<seconds since 1970>,v1=<HMAC-SHA256 of 't.body' under the secret, hex>".
std::string WebhookSignature(const std::string& secret, std::int64_t at_s, const std::string& body);

}  // namespace skyquilt::api
