// WMS 1.1.1 and 1.3.0 in Web Mercator and geographic coordinates, for ground stations and older GIS programs:
// of one map at /wms/{flight}, with the layer "map", and at /wms of all maps that a request may read, each a
// layer by the flight's id. GetCapabilities, GetMap, GetFeatureInfo. OGC 01-068r3 and 06-042.
#pragma once

#include "api/http/router.h"
#include "api/service.h"

namespace skyquilt::api {

void AddWmsRoutes(Router& router, Service& service);

}  // namespace skyquilt::api
