// Frame `merc`: EPSG:3857 metres, x east, y north. Spherical formulas on WGS84 degrees as EPSG method 1024
// has them. Pure functions; any thread. Latitudes beyond +-85.0511 lie outside the tile square.
#pragma once

#include <Eigen/Core>

#include "core/geo/lat_lon.h"
#include "core/geo/lat_lon_bounds.h"

namespace skyquilt::geo {

inline constexpr double kMercHalfWidthM = kPi * kWgs84SemiMajorM;  // 20037508.342789244

Eigen::Vector2d MercFromLatLon(const LatLon& position);
LatLon LatLonFromMerc(const Eigen::Vector2d& point_in_merc);
Bounds2 MercFromLatLonBounds(const LatLonBounds& bounds);
LatLonBounds LatLonBoundsFromMerc(const Bounds2& bounds_in_merc);
// How many metres on the ground one merc metre is at this latitude, east-west. (Mercator is conformal on the
// sphere; on the ellipsoid north-south differs by up to 0.7 %.)
double GroundMetresPerMercMetre(double lat_deg);
// Square metres of ground under one of merc.
double GroundPerMercArea(double lat_deg);

}  // namespace skyquilt::geo
