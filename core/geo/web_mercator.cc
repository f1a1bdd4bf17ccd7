#include "core/geo/web_mercator.h"

#include <cmath>

namespace skyquilt::geo {

Eigen::Vector2d MercFromLatLon(const LatLon& position) {
  const double lat_rad = DegToRad(position.lat_deg);
  return {kWgs84SemiMajorM * DegToRad(position.lon_deg), kWgs84SemiMajorM * std::asinh(std::tan(lat_rad))};
}

LatLon LatLonFromMerc(const Eigen::Vector2d& point_in_merc) {
  return {RadToDeg(std::atan(std::sinh(point_in_merc.y() / kWgs84SemiMajorM))),
          RadToDeg(point_in_merc.x() / kWgs84SemiMajorM)};
}

Bounds2 MercFromLatLonBounds(const LatLonBounds& bounds) {
  Bounds2 in_merc;
  in_merc.Include(MercFromLatLon(bounds.SouthWest()));
  in_merc.Include(MercFromLatLon(bounds.NorthEast()));
  return in_merc;
}

LatLonBounds LatLonBoundsFromMerc(const Bounds2& bounds_in_merc) {
  const LatLon south_west = LatLonFromMerc(bounds_in_merc.min);
  const LatLon north_east = LatLonFromMerc(bounds_in_merc.max);
  return {south_west.lon_deg, south_west.lat_deg, north_east.lon_deg, north_east.lat_deg};
}

double GroundMetresPerMercMetre(double lat_deg) {
  const double lat_rad = DegToRad(lat_deg);
  const double sin_lat = std::sin(lat_rad);
  return std::cos(lat_rad) / std::sqrt(1.0 - kWgs84EccentricitySquared * sin_lat * sin_lat);
}

double GroundPerMercArea(double lat_deg) {
  const double sin_lat = std::sin(DegToRad(lat_deg));
  const double along = GroundMetresPerMercMetre(lat_deg);
  const double w = 1.0 - kWgs84EccentricitySquared * sin_lat * sin_lat;
  return along * along * (1.0 - kWgs84EccentricitySquared) / w;
}

}  // namespace skyquilt::geo
