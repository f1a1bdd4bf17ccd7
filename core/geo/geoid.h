// Geoid heights: ellipsoid from mean sea level. Uses PROJ's EGM96 grid where it is installed (Debian:
// proj-data). Any thread: each keeps its own PROJ context.
#pragma once

#include <optional>

#include "core/geo/lat_lon.h"

namespace skyquilt::geo {

// Height of the EGM96 geoid above the ellipsoid, about +-0.5 m; nothing where PROJ has no grid.
std::optional<double> GeoidHeightM(const LatLon& position);

}  // namespace skyquilt::geo
