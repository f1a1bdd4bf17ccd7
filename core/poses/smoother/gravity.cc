#include "core/poses/smoother/gravity.h"

#include <cmath>

#include "core/geo/lat_lon.h"

namespace skyquilt::poses {

double NormalGravityMps2(double lat_deg, double height_ellipsoid_m) {
  const double sine = std::sin(geo::DegToRad(lat_deg));
  const double s2 = sine * sine;
  const double on_ellipsoid =
      9.7803253359 * (1.0 + 0.00193185265241 * s2) / std::sqrt(1.0 - geo::kWgs84EccentricitySquared * s2);
  return on_ellipsoid - 3.086e-6 * height_ellipsoid_m;
}

}  // namespace skyquilt::poses
