// The verdict on a flight's files before any map is made: what they record, what is missing, what it will
// cost.
#pragma once

#include "api/http/router.h"
#include "api/service.h"

namespace skyquilt::api {

void AddVerdictRoute(Router& router, Service& service);

}  // namespace skyquilt::api
