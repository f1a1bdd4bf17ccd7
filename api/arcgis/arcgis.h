// A map as an ArcGIS MapServer, as far as ArcGIS clients use a tiled one: the service description, and tiles
// by level, row and column.
#pragma once

#include "api/http/router.h"
#include "api/service.h"

namespace skyquilt::api {

void AddArcgisRoutes(Router& router, Service& service);

}  // namespace skyquilt::api
