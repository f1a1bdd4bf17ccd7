// RouteRequest: from a checked request head to the route that answers it, or to the answer that nobody may
// give it to a handler: a name that is not this server's, no such address, a method that is not taken, a page
// of another site. Whether the client may is asked where the handler runs (api/auth/access). No socket. Any
// thread.
#pragma once

#include <string>

#include "api/http/router.h"
#include "api/service.h"
#include "server/routing/http_settings.h"
#include "server/routing/request_head.h"

namespace skyquilt::server {

struct Routed {
  const api::Route* route = nullptr;  // none: `response` is the answer already
  api::Request request;
  api::Response response;
  api::Headers cors;  // for the answer, whatever it is: what pages of other sites may do with it
};

// Takes the headers out of the head, and the base path off its target. `peer`: the connection's other end;
// `by_network`: it came by an address that was opened for links, where everybody needs a token.
Routed RouteRequest(RequestHead& head, const api::Router& router, const HttpSettings& settings,
                    api::Service& service, const std::string& request_id, const std::string& peer,
                    bool by_network);

// A target without its query: what may be shown and logged.
std::string PathOf(const std::string& target);

}  // namespace skyquilt::server
