// WmtsCapabilities: the document by which WMTS 1.0.0 describes maps: that of one, or all in a list. Pure.
#pragma once

#include <string>

#include "api/ogc/listed_maps.h"

namespace skyquilt::api {

std::string WmtsCapabilities(const ListedMaps& listed);

}  // namespace skyquilt::api
