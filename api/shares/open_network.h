// A server that listens to its own machine alone, seen by the network for as long as it runs: what links need
// that are handed to others. Asked by who sits at that machine, and by nobody else. Whoever comes by those
// addresses needs a token (api/auth/access), so that links read and nobody writes who could not before.
#pragma once

#include "api/http/router.h"
#include "api/service.h"

namespace skyquilt::api {

// Is that this request's to ask, and something that this server does?
bool MayOpenNetwork(const Service& service, const Request& request);

void AddNetworkRoute(Router& router, Service& service);

}  // namespace skyquilt::api
