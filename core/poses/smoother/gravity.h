// Gravity on the WGS84 ellipsoid, in m/s2. Pure; any thread. Source: Somigliana's formula with the free-air
// gradient, as in P. D. Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation (2013).
#pragma once

namespace skyquilt::poses {

inline constexpr double kStandardGravityMps2 = 9.80665;
// Normal gravity at a latitude and a height over the ellipsoid.
double NormalGravityMps2(double lat_deg, double height_ellipsoid_m);

}  // namespace skyquilt::poses
