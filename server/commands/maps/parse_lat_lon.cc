#include "server/commands/maps/parse_lat_lon.h"

#include <fmt/core.h>

#include <cstdio>

#include "server/terminal/fail.h"

namespace skyquilt::server {

geo::LatLon ParseLatLon(std::string_view command, std::string_view option, const std::string& text) {
  geo::LatLon place;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%lf,%lf%c", &place.lat_deg, &place.lon_deg, &rest) == 2) return place;
  Fail(std::string(command).c_str(),
       {ErrorCode::kInvalidArgument,
        fmt::format("{} is '{}'; write it as LAT,LON in degrees, like 46.80,7.10.", option, text), ""});
}

}  // namespace skyquilt::server
