// TMS 1.0.0 (OSGeo's Tile Map Service): rows counted from the south.
// https://wiki.osgeo.org/wiki/Tile_Map_Service_Specification
#pragma once

#include "api/http/router.h"
#include "api/service.h"

namespace skyquilt::api {

void AddTmsRoutes(Router& router, Service& service);

}  // namespace skyquilt::api
