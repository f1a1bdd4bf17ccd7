// POST /api/v1/flights/{flight}/volume: what lies above and below a base, or the heights of an earlier
// flight, within a polygon of a map's heights (core/surface/terrain/volume). Any thread; reads up to eight
// million cells. Errors: kInvalidArgument (no JSON, no such base), kUnprocessable (no polygon, or no height
// within or along it), kNotFound (no such flight, no map, or one without heights), kCorrupt, and those of
// fetching.
#pragma once

#include "api/http/router.h"
#include "api/service.h"

namespace skyquilt::api {

void AddVolumeRoute(Router& router, Service& service);

}  // namespace skyquilt::api
