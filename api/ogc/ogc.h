// OGC API - Tiles 1.0 at /ogc: landing page, conformance, collections (one a map) with their tilesets, tile
// matrix sets, and tiles by row and column. OGC 20-057.
#pragma once

#include "api/http/router.h"
#include "api/service.h"

namespace skyquilt::api {

void AddOgcRoutes(Router& router, Service& service);

}  // namespace skyquilt::api
