// Access: may this request do what its route does? Until a first token is made everything is open (the server
// then listens to its own machine only, or was started with --open). From then on each route requires its
// scope (Route::scope), shown as "Authorization: Bearer ...", also after the last token is revoked or has
// expired. "?token=" is for clients that cannot set headers, for reading only, and for NodeODM clients, whose
// protocol uses it. Whoever comes by an address that was opened for links (Request::needs_token) needs one
// all the same. A share only reads its flight also where everything is open, and nothing once it has ended.
// Which flights a request may be about is decided in api/auth/flight_access.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "api/http/http_message.h"
#include "api/http/router.h"
#include "api/service.h"

namespace skyquilt::api {

// True for the routes of the NodeODM contract, which answers refusals in a form of its own.
bool IsNode(std::string_view pattern);

// The refusal, if the request may not pass, or its token has no more of what it may take (api/auth/limits);
// else the request knows whose it is.
std::optional<Response> CheckAccess(Service& service, Request& request, const Route& route);

// What a token opened is for whoever shows it: caches between are told (private, Vary), but where the
// operator said that theirs keeps tokens apart (Service::has_keyed_cache).
void KeepToAsker(const Service& service, const Request& request, Response& response);

// For answers that go on for long: false from when the token it came with (Request::owner) was revoked or has
// ended, also where the server asks nobody for one.
bool IsStillGood(Service& service, const std::string& owner);

// 256 random bits as text. Shown once, stored nowhere.
std::string NewTokenText();
// That of a share, which is known as one when it has ended, too.
std::string NewShareText();
std::string HashToken(std::string_view text);

}  // namespace skyquilt::api
