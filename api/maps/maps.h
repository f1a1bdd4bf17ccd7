// OGC API Maps, Part 1 (OGC 20-058): a flight's map as one picture of any box in any coordinate system, at
// /ogc/collections/{flight}/map, drawn by what WMS draws with and within its limits.
#pragma once

#include "api/http/router.h"
#include "api/service.h"

namespace skyquilt::api {

void AddMapRoutes(Router& router, Service& service);

}  // namespace skyquilt::api
