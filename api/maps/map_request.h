// The parameters of OGC API Maps (OGC 20-058, clauses 9, 11 to 13 and 16), checked: which box of a map, in
// which coordinate system, in how many pixels, on which background. What a request leaves out is as the
// standard has it, and where that leaves it to the server:
//   nothing       the whole map, up to kUsualMapSidePx on the longer side, never larger than its own pixels
//   width, height the whole map, within both (one of them: the other follows from the map's shape)
//   center        around it as finely as the map is; so many pixels as above of a square
//   scale-denominator   the whole map, no more than the middle kUsualMapSidePx on each side of it
// One thread at a time. Errors: kInvalidArgument (400), kTooLarge (413), and what a format has.
#pragma once

#include "api/common/background.h"
#include "api/http/http_message.h"
#include "api/tiles/map_crs.h"
#include "core/geo/bounds.h"

namespace skyquilt::api {

inline constexpr int kUsualMapSidePx = 1024;

// What is known of a map before it is drawn.
struct WholeMap {
  geo::LatLonBounds bounds;
  double pixel_in_merc_m = 1.0;  // of its finest zoom
};

struct MapBackground {
  Rgb colour = kWhite;  // where the map shows nothing
  bool is_transparent = true;
  Rgb void_colour = kWhite;  // outside of what the coordinate system has places for
  bool is_void_transparent = true;

  bool is_one() const { return colour == void_colour && is_transparent == is_void_transparent; }
};

struct MapRequest {
  MapCrs crs;
  geo::Bounds2 box;  // in crs, x before y
  int width_px = 0, height_px = 0;
  MapBackground background;
};
Result<MapRequest> ParseMapRequest(const Request& request, const WholeMap& map);

}  // namespace skyquilt::api
