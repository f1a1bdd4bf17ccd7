// WMS 1.1.1 and 1.3.0 of one map at /wms/{flight}: GetCapabilities and GetMap in Web Mercator and geographic
// coordinates, for ground stations and older GIS programs. OGC 01-068r3 and 06-042.
#pragma once

#include "api/http/router.h"
#include "api/service.h"
#include "core/image/picture_format.h"

namespace skyquilt::api {

void AddWmsRoutes(Router& router, Service& service);

// The window of a GetMap request, checked. Errors: kInvalidArgument, whose detail is WMS' own code or empty.
struct WmsMap {
  double west = 0.0, south = 0.0, east = 0.0, north = 0.0;  // merc metres, or degrees where is_geographic
  bool is_geographic = false;
  int width_px = 0;
  int height_px = 0;
  bool is_transparent = false;
  image::PictureFormat format = image::PictureFormat::kPng;
};
Result<WmsMap> ParseGetMap(const Request& request);

}  // namespace skyquilt::api
