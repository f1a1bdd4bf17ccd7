// The notes and measurements of a flight, which everybody sees who opens it: read, and written as a whole.
// They lie among the flight's files, as GeoJSON.
#pragma once

#include "api/http/router.h"
#include "api/service.h"

namespace skyquilt::api {

void AddNotesRoutes(Router& router, Service& service);

}  // namespace skyquilt::api
