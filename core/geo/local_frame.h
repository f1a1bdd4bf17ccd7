// LocalFrame: the flight's `enu` frame (x east, y north, z up; metres; true north), tangent to the ellipsoid
// at the flight's origin. Exact through ECEF, no flat-Earth shortcut. A value; any thread.
#pragma once

#include <Eigen/Core>

#include "core/geo/lat_lon.h"
#include "core/geo/rigid3.h"

namespace skyquilt::geo {

// The line straight up and down through a geographic position, in `enu`.
struct Vertical {
  Eigen::Vector3d on_ellipsoid;
  Eigen::Vector3d up;  // one metre of ellipsoidal height

  // Where it meets the plane z = z_in_enu_m.
  Eigen::Vector3d AtHeight(double z_in_enu_m) const {
    return on_ellipsoid + (z_in_enu_m - on_ellipsoid.z()) / up.z() * up;
  }
};

class LocalFrame {
 public:
  explicit LocalFrame(const Wgs84& origin);

  const Wgs84& origin() const { return origin_; }
  const Rigid3& ecef_from_enu() const { return ecef_from_enu_; }

  Eigen::Vector3d EnuFromWgs84(const Wgs84& wgs84) const;
  Wgs84 Wgs84FromEnu(const Eigen::Vector3d& point_in_enu) const;
  Vertical VerticalAt(const LatLon& position) const;
  // The point of the plane z = z_in_enu_m straight above or below a geographic position.
  Eigen::Vector3d EnuAtHeight(const LatLon& position, double z_in_enu_m) const;

 private:
  Wgs84 origin_;
  Rigid3 ecef_from_enu_;
  Rigid3 enu_from_ecef_;
};

}  // namespace skyquilt::geo
