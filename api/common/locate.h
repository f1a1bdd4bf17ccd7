// Photos and points: which photos see a place, and where a photo's pixel lies. Any thread.
#pragma once

#include "api/http/router.h"
#include "api/service.h"
#include "core/pipeline/report/locate.h"

namespace skyquilt::api {

void AddLocateRoutes(Router& router, Service& service);

// The cameras and the ground that the map of a flight was made with. Errors: kNotFound (no such flight, no
// map, or one without them), kCorrupt, kIo.
Result<pipeline::LocatedMap> ReadLocatedMap(Service& service, const std::string& flight_id);
// A parameter that must be there and a number: kInvalidArgument.
Result<double> NumberParameter(const Request& request, const char* name);

}  // namespace skyquilt::api
