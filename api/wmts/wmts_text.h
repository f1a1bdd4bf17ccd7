// WmtsCapabilities: the document by which WMTS 1.0.0 describes maps: that of one, or all in a list. Pure.
#pragma once

#include <string>

#include "api/views/listed_maps.h"

namespace skyquilt::api {

// As GeoWebCache names tiles that are JPEG inside and PNG at the edge: sent as they are stored, which costs
// neither the server nor the network anything.
inline constexpr const char* kStoredTileType = "image/vnd.jpeg-png";

std::string WmtsCapabilities(const ListedMaps& listed);

}  // namespace skyquilt::api
