// Downloads of a finished map: MBTiles, GeoTIFF, report, photo footprints.
#pragma once

#include "api/http/router.h"
#include "api/service.h"

namespace skyquilt::api {

void AddDownloadRoutes(Router& router, Service& service);

}  // namespace skyquilt::api
