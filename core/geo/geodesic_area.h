// GeodesicAreaM2: what a ring of positions encloses on the ellipsoid WGS 84, in square metres; its edges are
// geodesics. Whatever way round it goes, and whether or not its last position is the first again. Of a ring
// that crosses itself, what is enclosed one way less what is the other. Pure.
#pragma once

#include <vector>

#include "core/geo/lat_lon.h"

namespace skyquilt::geo {

double GeodesicAreaM2(const std::vector<LatLon>& ring);

}  // namespace skyquilt::geo
