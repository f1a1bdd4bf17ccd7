// The files of one flight: list, raw PUT (curl -T), delete; and multipart with any number of files, either
// into a flight or to make one and queue its job at once.
#pragma once

#include "api/http/router.h"
#include "api/service.h"

namespace skyquilt::api {

void AddFileRoutes(Router& router, Service& service);
void AddMultipartRoutes(Router& router, Service& service);

}  // namespace skyquilt::api
