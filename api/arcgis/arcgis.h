// A map as an ArcGIS MapServer, as far as ArcGIS' programs ask it of a tiled one: the service's description
// and its tiles by level, row and column.
#pragma once

#include "api/http/router.h"
#include "api/service.h"

namespace skyquilt::api {

void AddArcgisRoutes(Router& router, Service& service);

}  // namespace skyquilt::api
