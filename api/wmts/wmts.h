// WMTS 1.0.0, both bindings: of one map at /wmts/{flight}, with the layer "map", and at /wmts of all maps
// that a request may read, each a layer by the flight's id. OGC 07-057r7.
#pragma once

#include "api/http/router.h"
#include "api/service.h"

namespace skyquilt::api {

void AddWmtsRoutes(Router& router, Service& service);

}  // namespace skyquilt::api
