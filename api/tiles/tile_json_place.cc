#include "api/tiles/tile_json_place.h"

#include <cmath>
#include <nlohmann/json.hpp>

namespace skyquilt::api {

void AddPlace(const geo::LatLonBounds& bounds, int center_zoom, nlohmann::ordered_json& document) {
  const geo::LatLonBounds stated = bounds.AroundWhereAcross();
  const geo::LatLon middle = bounds.Middle();
  document["bounds"] = stated.ToArray();
  document["center"] = {std::remainder(middle.lon_deg, 360.0), middle.lat_deg, center_zoom};
  if (stated.west_deg != bounds.west_deg) document["across_bounds"] = bounds.ToArray();
}

}  // namespace skyquilt::api
