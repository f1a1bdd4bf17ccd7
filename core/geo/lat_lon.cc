#include "core/geo/lat_lon.h"

#include <cmath>

namespace skyquilt::geo {

double WrapRad(double rad) {
  const double wrapped = std::remainder(rad, 2.0 * kPi);
  return wrapped <= -kPi ? wrapped + 2.0 * kPi : wrapped;
}

Result<LatLon> LatLon::Make(double lat_deg, double lon_deg) {
  if (!std::isfinite(lat_deg) || !std::isfinite(lon_deg) || std::abs(lat_deg) > 90.0 ||
      std::abs(lon_deg) > 180.0) {
    return Error{ErrorCode::kInvalidArgument,
                 "A position needs a latitude in -90..90 and a longitude in -180..180 degrees.", ""};
  }
  return LatLon{lat_deg, lon_deg};
}

LatLon OnTheWay(const LatLon& from, const LatLon& to, double share) {
  const double east_deg = std::remainder(to.lon_deg - from.lon_deg, 360.0);
  return {from.lat_deg + share * (to.lat_deg - from.lat_deg),
          std::remainder(from.lon_deg + share * east_deg, 360.0)};
}

Eigen::Vector3d EcefFromWgs84(const Wgs84& wgs84) {
  const double lat_rad = DegToRad(wgs84.lat_deg);
  const double lon_rad = DegToRad(wgs84.lon_deg);
  const double sin_lat = std::sin(lat_rad);
  const double cos_lat = std::cos(lat_rad);
  const double prime_vertical_m =
      kWgs84SemiMajorM / std::sqrt(1.0 - kWgs84EccentricitySquared * sin_lat * sin_lat);
  const double h = wgs84.height_ellipsoid_m;
  return {(prime_vertical_m + h) * cos_lat * std::cos(lon_rad),
          (prime_vertical_m + h) * cos_lat * std::sin(lon_rad),
          (prime_vertical_m * (1.0 - kWgs84EccentricitySquared) + h) * sin_lat};
}

Wgs84 Wgs84FromEcef(const Eigen::Vector3d& point_in_ecef) {
  const double p = std::hypot(point_in_ecef.x(), point_in_ecef.y());
  const double z = point_in_ecef.z();
  const double semi_minor_m = kWgs84SemiMajorM * (1.0 - kWgs84Flattening);
  const double second_eccentricity_squared = kWgs84EccentricitySquared / (1.0 - kWgs84EccentricitySquared);
  // Bowring: iterate on the parametric latitude.
  double tan_beta = z * kWgs84SemiMajorM / (std::max(p, 1e-9) * semi_minor_m);
  double lat_rad = 0.0;
  for (int i = 0; i < 4; ++i) {
    const double beta = std::atan(tan_beta);
    const double sin_beta = std::sin(beta);
    const double cos_beta = std::cos(beta);
    lat_rad = std::atan2(z + second_eccentricity_squared * semi_minor_m * sin_beta * sin_beta * sin_beta,
                         p - kWgs84EccentricitySquared * kWgs84SemiMajorM * cos_beta * cos_beta * cos_beta);
    tan_beta = (1.0 - kWgs84Flattening) * std::tan(lat_rad);
  }
  const double sin_lat = std::sin(lat_rad);
  const double cos_lat = std::cos(lat_rad);
  const double root = std::sqrt(1.0 - kWgs84EccentricitySquared * sin_lat * sin_lat);
  const double height_m = p * cos_lat + z * sin_lat - kWgs84SemiMajorM * root;
  return {RadToDeg(lat_rad), RadToDeg(std::atan2(point_in_ecef.y(), point_in_ecef.x())), height_m};
}

}  // namespace skyquilt::geo
