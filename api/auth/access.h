// Access: may this request do what its route does? Until a first token is made everything is open (the server
// then listens to its own machine, or was told to be open). From then on each route asks for a scope, shown
// as "Authorization: Bearer ...", also when the last token is revoked or has ended; "?token=" serves clients
// that cannot set headers, for reading, and for the node's clients, whose contract has it so. Which flights
// it may be done to is api/auth/flight_access. Any thread.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "api/http/http_message.h"
#include "api/service.h"
#include "storage/catalogue/tokens.h"

namespace skyquilt::api {

// What a route asks for; absent: nothing. A route that is not in the list asks for everything.
std::optional<storage::Scope> ScopeOf(Method method, std::string_view pattern);
// True when the list names the route: the test that walks all routes asks it.
bool IsListed(Method method, std::string_view pattern);

// The refusal, if the request may not pass, or its token has no more of what it may take (api/auth/limits);
// else the request knows whose it is.
std::optional<Response> CheckAccess(Service& service, Request& request, std::string_view pattern);

// For answers that go on for long: false from when the token it came with was revoked or has ended.
bool IsStillGood(Service& service, const Request& request);

// 256 random bits as text. Shown once, stored nowhere.
std::string NewTokenText();
std::string HashToken(std::string_view text);

}  // namespace skyquilt::api
