// Shares: tokens that open one flight for reading, made and revoked by whoever may change the flight. GET and
// POST /api/v1/flights/{flight}/shares, DELETE .../shares/{share}. The token is shown once, when it is made;
// it only reads also where the server asks nobody for one.
#pragma once

#include "api/http/router.h"
#include "api/service.h"

namespace skyquilt::api {

void AddShareRoutes(Router& router, Service& service);

}  // namespace skyquilt::api
