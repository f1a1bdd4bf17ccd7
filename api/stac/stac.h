// STAC API 1.0: the maps that a client may read as one collection, "flights", with item search by box, shape
// and time; and /stac/{flight}, the item of one map. A token sees in all of them what it may read alone.
// https://github.com/radiantearth/stac-api-spec/tree/v1.0.0
#pragma once

#include "api/http/router.h"
#include "api/service.h"

namespace skyquilt::api {

void AddStacRoutes(Router& router, Service& service);

}  // namespace skyquilt::api
