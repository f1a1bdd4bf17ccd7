// SunDirection: where the sun stands, as a unit vector in enu (east, north, up) at a place; below the horizon
// `up` is negative. To 0.02 degrees between 1950 and 2050, refraction left out. Any thread.
// Source: low-precision formulas of the Astronomical Almanac, section C.
#pragma once

#include <Eigen/Core>
#include <chrono>

#include "core/geo/lat_lon.h"

namespace skyquilt::simulate {

Eigen::Vector3d SunDirection(const geo::LatLon& place, std::chrono::sys_time<std::chrono::microseconds> utc);

}  // namespace skyquilt::simulate
