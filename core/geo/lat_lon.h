// Geographic positions on WGS84. The only types that hold degrees. Frame `wgs84` and `ecef` (metres).
// Functions are pure; any thread. Method: NIMA TR8350.2 (WGS84 constants); ECEF to geodetic by Bowring's
// iteration, good to nanometres at heights below 100 km.
#pragma once

#include <Eigen/Core>

#include "core/base/result.h"

namespace skyquilt::geo {

inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double kWgs84SemiMajorM = 6378137.0;
inline constexpr double kWgs84Flattening = 1.0 / 298.257223563;
inline constexpr double kWgs84EccentricitySquared = kWgs84Flattening * (2.0 - kWgs84Flattening);

constexpr double DegToRad(double deg) { return deg * (kPi / 180.0); }
constexpr double RadToDeg(double rad) { return rad * (180.0 / kPi); }
// The same angle in (-pi, pi].
double WrapRad(double rad);

struct LatLon {
  double lat_deg = 0.0;
  double lon_deg = 0.0;

  // Refuses what is not a position on Earth (NaN, |lat| > 90, |lon| > 180).
  static Result<LatLon> Make(double lat_deg, double lon_deg);
  friend bool operator==(const LatLon&, const LatLon&) = default;
};

// `share` of the way from one to the other, the short way round the Earth; latitude and longitude grow
// evenly.
LatLon OnTheWay(const LatLon& from, const LatLon& to, double share);

struct Wgs84 {
  double lat_deg = 0.0;
  double lon_deg = 0.0;
  double height_ellipsoid_m = 0.0;
};

Eigen::Vector3d EcefFromWgs84(const Wgs84& wgs84);
Wgs84 Wgs84FromEcef(const Eigen::Vector3d& point_in_ecef);

}  // namespace skyquilt::geo
