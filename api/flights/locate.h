// Photos and points: which photos see a place, and where a photo's pixel lies.
#pragma once

#include "api/http/router.h"
#include "api/service.h"

namespace skyquilt::api {

void AddLocateRoutes(Router& router, Service& service);

}  // namespace skyquilt::api
