// For operators and monitoring: liveness, readiness, metrics, version, API contract.
#pragma once

#include "api/http/router.h"
#include "api/service.h"

namespace skyquilt::api {

void AddOpsRoutes(Router& router, Service& service);
void AddDocsRoute(Router& router);

}  // namespace skyquilt::api
