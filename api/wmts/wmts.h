// WMTS 1.0.0 of one map, both bindings complete: KVP at /wmts/{flight}, REST below it. OGC 07-057r7.
#pragma once

#include "api/http/router.h"
#include "api/service.h"

namespace skyquilt::api {

void AddWmtsRoutes(Router& router, Service& service);

}  // namespace skyquilt::api
