// Tile matrix sets and tilesets as documents (OGC 17-083r4, OGC 20-057): the list of all, the definition of
// each, and what a map has in them. Any thread.
#pragma once

#include "api/views/map_view.h"

namespace skyquilt::api {

Response MatrixSetList(const Request& request);
// Of the parameter {set}.
Result<Response> MatrixSetDocument(const Request& request);

Response TilesetList(const MapView& map);
// Precondition: a set of the map.
Response TilesetDocument(const MapView& map, const MapSet& set);

}  // namespace skyquilt::api
