#include "core/geo/geodesic.h"

#include <geodesic.h>

#include <algorithm>
#include <cmath>

namespace skyquilt::geo {

double MetresApart(const LatLon& a, const LatLon& b) {
  constexpr double kEarthRadiusM = 6'371'000.0;
  const double chord_m =
      (EcefFromWgs84({a.lat_deg, a.lon_deg, 0.0}) - EcefFromWgs84({b.lat_deg, b.lon_deg, 0.0})).norm();
  return 2.0 * kEarthRadiusM * std::asin(std::min(1.0, 0.5 * chord_m / kEarthRadiusM));
}

double GeodesicAreaM2(const std::vector<LatLon>& ring) {
  geod_geodesic earth;
  geod_init(&earth, kWgs84SemiMajorM, kWgs84Flattening);
  std::vector<double> lats_deg, lons_deg;
  for (const LatLon& corner : ring) {
    lats_deg.push_back(corner.lat_deg);
    lons_deg.push_back(corner.lon_deg);
  }
  double area_m2 = 0.0, perimeter_m = 0.0;
  geod_polygonarea(&earth, lats_deg.data(), lons_deg.data(), static_cast<int>(ring.size()), &area_m2,
                   &perimeter_m);
  return std::abs(area_m2);
}

}  // namespace skyquilt::geo
