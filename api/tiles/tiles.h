// Tiles of the map that a flight shows: XYZ images with content-hash ETags, and TileJSON 3.0.0.
// https://github.com/mapbox/tilejson-spec/tree/master/3.0.0
#pragma once

#include "api/router.h"
#include "api/service.h"

namespace skyquilt::api {

void AddTileRoutes(Router& router, Service& service);
void AddTileJsonRoute(Router& router, Service& service);

// The side of a tileset's tiles, from its metadata; 256 where it does not say.
int TileSizePx(const storage::Tileset& tileset);

}  // namespace skyquilt::api
