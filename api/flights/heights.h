// The ground's height along a line (core/pipeline/report/ground_profile), of maps that have their cameras
// kept with them: not of those that were imported; and the heights of its surfaces, where it has these
// (api/surface). Reads the cameras of the whole flight. Any thread. Errors:
// kInvalidArgument (no JSON), kTooLarge, kUnprocessable (no line), kNotFound (no such flight, no map, or one
// that knows no heights), kCorrupt, kIo.
#pragma once

#include <string_view>
#include <vector>

#include "api/service.h"
#include "core/base/result.h"
#include "core/geo/lat_lon.h"

namespace skyquilt::api {

// GeoJSON in longitude and latitude: a LineString, or a Feature of one. Pure.
Result<std::vector<geo::LatLon>> ParseLine(std::string_view json);

}  // namespace skyquilt::api
