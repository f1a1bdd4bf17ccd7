#include "core/geo/local_frame.h"

#include <cmath>

namespace skyquilt::geo {

LocalFrame::LocalFrame(const Wgs84& origin) : origin_(origin) {
  const double lat = DegToRad(origin.lat_deg);
  const double lon = DegToRad(origin.lon_deg);
  Eigen::Matrix3d axes;  // columns: east, north, up in ecef
  axes.col(0) << -std::sin(lon), std::cos(lon), 0.0;
  axes.col(1) << -std::sin(lat) * std::cos(lon), -std::sin(lat) * std::sin(lon), std::cos(lat);
  axes.col(2) << std::cos(lat) * std::cos(lon), std::cos(lat) * std::sin(lon), std::sin(lat);
  ecef_from_enu_ = {Eigen::Quaterniond(axes).normalized(), EcefFromWgs84(origin)};
  enu_from_ecef_ = ecef_from_enu_.Inverse();
}

Eigen::Vector3d LocalFrame::EnuFromWgs84(const Wgs84& wgs84) const { return enu_from_ecef_ * EcefFromWgs84(wgs84); }

Wgs84 LocalFrame::Wgs84FromEnu(const Eigen::Vector3d& point_in_enu) const {
  return Wgs84FromEcef(ecef_from_enu_ * point_in_enu);
}

Eigen::Vector3d LocalFrame::EnuAtHeight(const LatLon& position, double z_in_enu_m) const {
  Wgs84 point{position.lat_deg, position.lon_deg, origin_.height_ellipsoid_m + z_in_enu_m};
  Eigen::Vector3d enu = EnuFromWgs84(point);
  // The local vertical differs from the frame's z by distance/Earth radius: two corrections leave nanometres.
  for (int i = 0; i < 2; ++i) {
    point.height_ellipsoid_m += z_in_enu_m - enu.z();
    enu = EnuFromWgs84(point);
  }
  return enu;
}

}  // namespace skyquilt::geo
