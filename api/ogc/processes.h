// OGC API - Processes 1.0: the same jobs as /api/v1/jobs, under the names that its clients know. One process,
// "stitch": a flight's photos in, its map out; always asynchronous.
// https://docs.ogc.org/is/18-062r2/18-062r2.html
#pragma once

#include "api/http/router.h"
#include "api/service.h"

namespace skyquilt::api {

void AddProcessRoutes(Router& router, Service& service);

}  // namespace skyquilt::api
