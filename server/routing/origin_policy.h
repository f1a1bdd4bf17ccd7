// What pages of other sites may do. A page can make a name of its own point at this machine (DNS rebinding)
// and then speak to it as to itself: where no token is asked for, only names that the server knows as its own
// are answered (public_address.h). Other pages may read answers, and send changes, where tokens are asked for
// (a page has none unless it was given one) or where the operator named them. Pure; any thread.
#pragma once

#include <string>
#include <string_view>

#include "api/http/http_message.h"
#include "server/routing/http_settings.h"
#include "server/routing/request_head.h"

namespace skyquilt::server {

// A page that is not this server's sent this: by Sec-Fetch-Site where the browser says it, else by Origin,
// whose scheme, host and port must be those that the request was sent to.
bool IsFromForeignPage(const RequestHead& head, const HttpSettings& settings);

// May pages of this origin read answers? Then what the answer says of it.
bool IsOriginAllowed(std::string_view origin, const HttpSettings& settings, bool requires_token);
api::Headers CorsHeaders(const RequestHead& head, const HttpSettings& settings, bool requires_token);
// What a preflight is told besides: `allow` lists the methods of the path.
void AddPreflightHeaders(const std::string& allow, api::Headers& cors);

// "https://maps.example.org", "http://localhost:8081"; without a path.
bool IsOriginText(std::string_view text);

}  // namespace skyquilt::server
