// Terrain tiles of a map's heights, for views in three dimensions and hillshades: PNG in "terrarium" coding
// (core/render/map_layer.h), computed when they are asked for and kept as other made tiles are. There is one
// for every tile of the Earth: beyond the map its height goes on. GET /tiles/{flight}/terrain.json and
// /tiles/{flight}/terrain/{z}/{x}/{y}. Any thread.
#pragma once

#include "api/http/router.h"
#include "api/service.h"

namespace skyquilt::api {

inline constexpr const char* kTerrainTiles = "terrain";

void AddTerrainRoutes(Router& router, Service& service);

}  // namespace skyquilt::api
