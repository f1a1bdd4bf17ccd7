// What operators and monitors ask: is it alive, is it ready, what does it count, which version, what is the
// contract.
#pragma once

#include "api/http/router.h"
#include "api/service.h"

namespace skyquilt::api {

void AddOpsRoutes(Router& router, Service& service);
void AddDocsRoute(Router& router);

}  // namespace skyquilt::api
