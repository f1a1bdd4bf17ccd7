// TargetCrs: a coordinate system by its EPSG code, seen from a map: how long a metre on the ground is in it
// there. From PROJ's database; touches no network. Any thread. Errors: kUnprocessable (no such code, one that
// is not flat, or one that is not for this part of the Earth).
#pragma once

#include "core/base/result.h"
#include "core/geo/lat_lon.h"

namespace skyquilt::storage {

struct TargetCrs {
  double units_per_m_east = 1.0;
  double units_per_m_north = 1.0;
};

Result<TargetCrs> FindTargetCrs(int epsg, const geo::LatLon& middle);

}  // namespace skyquilt::storage
