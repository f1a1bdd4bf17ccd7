// The single parameters of OGC API Maps, each read and checked by itself: numbers, boxes, places and sides.
// Pure but for PROJ's database, from which coordinate systems come. Errors: kInvalidArgument; the message
// names the parameter.
#pragma once

#include <array>
#include <optional>
#include <string_view>

#include "api/http/http_message.h"
#include "api/tiles/map_crs.h"
#include "core/geo/bounds.h"

namespace skyquilt::api {

// Absent: the request does not have the parameter.
Result<std::optional<double>> PositiveNumberIn(const Request& request, const char* name);
// A whole number of pixels. Error: kTooLarge beyond the limit.
Result<std::optional<int>> PixelsIn(const Request& request, const char* name);
Result<std::optional<bool>> YesOrNoIn(const Request& request, const char* name);
// Without the parameter CRS84.
Result<MapCrs> CrsIn(const Request& request, const char* name);

// A box or a place with the system that it is in; x before y.
struct GivenBox {
  MapCrs crs;
  geo::Bounds2 box;
};
// By "bbox" and "bbox-crs", or by "subset" and "subset-crs", which may say one axis alone: of the other it
// has all of `whole`.
Result<std::optional<GivenBox>> BoxGivenIn(const Request& request, const geo::LatLonBounds& whole);
struct GivenPlace {
  MapCrs crs;
  Eigen::Vector2d place;
};
Result<std::optional<GivenPlace>> CenterGivenIn(const Request& request);

}  // namespace skyquilt::api
