// Lengths and areas on the ellipsoid WGS 84. Pure; any thread.
#pragma once

#include <vector>

#include "core/geo/lat_lon.h"

namespace skyquilt::geo {

// Between two positions, metres along a round Earth through them; to half a per cent, over any distance.
double MetresApart(const LatLon& a, const LatLon& b);

// What a ring of positions encloses, in square metres; its edges are geodesics. Whatever way round it goes,
// and whether or not its last position is the first again. Of a ring that crosses itself, what is enclosed
// one way less what is the other.
double GeodesicAreaM2(const std::vector<LatLon>& ring);

}  // namespace skyquilt::geo
