// GET /api/v1/access: what who asks may do here, so that a page offers nothing that would be refused.
#pragma once

#include "api/http/router.h"
#include "api/service.h"

namespace skyquilt::api {

void AddOwnAccessRoute(Router& router, Service& service);

}  // namespace skyquilt::api
