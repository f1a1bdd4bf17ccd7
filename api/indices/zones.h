// Zones of a map by an index, for spreaders and sprayers: values in classes of as many cells each, as GeoJSON
// or as a zipped shapefile: GET
// /api/v1/flights/{flight}/zones?index=ndvi&classes=5&format=geojson|shp&resolution_m=2. Any thread; takes up
// to some seconds. Errors: kInvalidArgument (parameters; the message teaches), kUnprocessable (no value
// anywhere, too many parts), kNotFound, kCorrupt, kIo.
#pragma once

#include <string>

#include "api/common/index_look.h"
#include "api/service.h"
#include "storage/rasters/class_outlines.h"

namespace skyquilt::api {

inline constexpr int kMinZones = 2, kMaxZones = 9;
inline constexpr int kMaxZoneCells = 2000;   // on the longer side of the grid
inline constexpr int kUsualZoneCells = 400;  // unless a resolution is said
inline constexpr int kMinPatchCells = 12;    // smaller patches become part of what surrounds them

Result<Response> AnswerZones(Service& service, const Request& request);

}  // namespace skyquilt::api
