// What can be known of the indices of a map: GET /api/v1/flights/{flight}/bands (its bands, the indices that
// can be made of them, the colours there are), /legend.svg and .png, /zones. Index tiles are tiles
// (api/tiles), values at a place and within a polygon are api/flights' point and statistics. Any thread.
#pragma once

#include "api/http/router.h"
#include "api/service.h"

namespace skyquilt::api {

void AddIndexRoutes(Router& router, Service& service);

}  // namespace skyquilt::api
