// WmsCapabilities: the document by which WMS 1.1.1 and 1.3.0 describe maps: that of one, or all in a list.
// Pure.
#pragma once

#include <string>

#include "api/ogc/listed_maps.h"

namespace skyquilt::api {

std::string WmsCapabilities(const ListedMaps& listed, bool is_newer);

}  // namespace skyquilt::api
