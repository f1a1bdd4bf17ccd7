// ParseLatLon: "46.80,7.10" of a command's option as a place. Ends the program with a message that names the
// option where it is none. Main thread.
#pragma once

#include <string>
#include <string_view>

#include "core/geo/lat_lon.h"

namespace skyquilt::server {

geo::LatLon ParseLatLon(std::string_view command, std::string_view option, const std::string& text);

}  // namespace skyquilt::server
