// RouteRequest: from a checked request head to the route that answers it, or to the answer that nobody may
// give it to a handler: no such address, a method that is not taken, a page of another origin. Whether the client
// may is asked where the handler runs (api/auth/access). No socket. Any thread.
#pragma once

#include <string>

#include "api/router.h"
#include "server/http_settings.h"
#include "server/request_head.h"

namespace skyquilt::server {

struct Routed {
  const api::Route* route = nullptr;  // none: `response` is the answer already
  api::Request request;
  api::Response response;
};

// Takes the headers out of the head.
Routed RouteRequest(RequestHead& head, const api::Router& router, const HttpSettings& settings,
                    const std::string& request_id);

// A target without its query: what may be shown and logged.
std::string PathOf(const std::string& target);

}  // namespace skyquilt::server
