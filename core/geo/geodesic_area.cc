#include "core/geo/geodesic_area.h"

#include <geodesic.h>

#include <cmath>

namespace skyquilt::geo {

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
