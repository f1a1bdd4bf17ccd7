// A map as a STAC 1.0 item: where it is, when its photos were taken, and every way to have it.
// https://github.com/radiantearth/stac-spec/blob/v1.0.0/item-spec/item-spec.md
#pragma once

#include "api/http/router.h"
#include "api/service.h"

namespace skyquilt::api {

void AddStacRoute(Router& router, Service& service);

}  // namespace skyquilt::api
