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

double GroundMetresPerMercMetre(double lat_deg) {
  const double lat_rad = DegToRad(lat_deg);
  const double sin_lat = std::sin(lat_rad);
  return std::cos(lat_rad) / std::sqrt(1.0 - kWgs84EccentricitySquared * sin_lat * sin_lat);
}

}  // namespace skyquilt::geo
