// TileJSON 3.0.0 of maps and layers. https://github.com/mapbox/tilejson-spec/tree/master/3.0.0 Any thread.
#pragma once

#include "api/http/router.h"
#include "api/service.h"

namespace skyquilt::api {

void AddTileJsonRoute(Router& router, Service& service);

}  // namespace skyquilt::api
