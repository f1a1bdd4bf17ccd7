// Files that other programs open to show the map: a QGIS layer, JOSM imagery, a GDAL description, an ArcGIS
// web map.
#pragma once

#include "api/http/router.h"
#include "api/service.h"

namespace skyquilt::api {

void AddConnectRoutes(Router& router, Service& service);

}  // namespace skyquilt::api
