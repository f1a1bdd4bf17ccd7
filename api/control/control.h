// The surveyed points of a flight and their marks: read, and written as a whole. They lie among the flight's
// files as the list that the stitcher reads.
#pragma once

#include "api/http/router.h"
#include "api/service.h"

namespace skyquilt::api {

void AddControlRoutes(Router& router, Service& service);

}  // namespace skyquilt::api
