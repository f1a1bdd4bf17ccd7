// Jobs: queue the stitching of a flight, watch it, cancel it. States are those of OGC API Processes.
#pragma once

#include "api/http/router.h"
#include "api/service.h"

namespace skyquilt::api {

void AddJobRoutes(Router& router, Service& service);

}  // namespace skyquilt::api
