// AddPlace: where the tiles of a TileJSON document are ("bounds", "center"). Its bounds neither go across the
// antimeridian nor beyond 180 degrees (TileJSON 3.0.0, 3.5): of a map across it they go all the way around,
// and "across_bounds" says where it is, its east beyond 180. Pure.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "core/geo/lat_lon_bounds.h"

namespace skyquilt::api {

void AddPlace(const geo::LatLonBounds& bounds, int center_zoom, nlohmann::ordered_json& document);

}  // namespace skyquilt::api
