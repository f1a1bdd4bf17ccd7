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

Eigen::Vector3d LocalFrame::EnuFromWgs84(const Wgs84& wgs84) const {
  return enu_from_ecef_ * EcefFromWgs84(wgs84);
}

Wgs84 LocalFrame::Wgs84FromEnu(const Eigen::Vector3d& point_in_enu) const {
  return Wgs84FromEcef(ecef_from_enu_ * point_in_enu);
}

Vertical LocalFrame::VerticalAt(const LatLon& position) const {
  const double lat = DegToRad(position.lat_deg), lon = DegToRad(position.lon_deg);
  const Eigen::Vector3d up_in_ecef(std::cos(lat) * std::cos(lon), std::cos(lat) * std::sin(lon),
                                   std::sin(lat));
  return {EnuFromWgs84({position.lat_deg, position.lon_deg, 0.0}), enu_from_ecef_.rotation * up_in_ecef};
}

Eigen::Vector3d LocalFrame::EnuAtHeight(const LatLon& position, double z_in_enu_m) const {
  return VerticalAt(position).AtHeight(z_in_enu_m);
}

}  // namespace skyquilt::geo
