// Eastings with the zone of UTM before them, as surveyors write them where a country has several zones (and
// EPSG:4647): 32,500,000 m is 500,000 m in zone 32. Before zone 10 they have seven digits, as northings have,
// and are not known. Any thread.
#pragma once

#include <optional>

#include "core/geo/crs/reference_system.h"

namespace skyquilt::geo {

struct ZonedEasting {
  int zone = 0;
  double east_m = 0.0;
};

std::optional<ZonedEasting> AsZonedEasting(double x);
// As `system` counts: without the zone before it where it is that zone, whose 500,000 m lie on its meridian.
double EastingIn(const ReferenceSystem& system, double x, double y);

}  // namespace skyquilt::geo
