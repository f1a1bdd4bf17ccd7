#include "core/geo/crs/zoned_easting.h"

#include <cmath>

namespace skyquilt::geo {

std::optional<ZonedEasting> AsZonedEasting(double x) {
  constexpr double kZoneM = 1e6, kMinEastM = 1e5, kMaxEastM = 9e5, kFirstZone = 10.0, kLastZone = 60.0;
  const double zone = std::floor(x / kZoneM), east_m = x - kZoneM * zone;
  if (!(zone >= kFirstZone && zone <= kLastZone && east_m >= kMinEastM && east_m <= kMaxEastM))
    return std::nullopt;
  return ZonedEasting{static_cast<int>(zone), east_m};
}

double EastingIn(const ReferenceSystem& system, double x, double y) {
  constexpr double kOnMeridianM = 500'000.0, kMeridianDeg = 0.05;  // datums shift it by less
  const auto zoned = system.is_geographic() ? std::nullopt : AsZonedEasting(x);
  const auto on_meridian = zoned ? system.ToLatLon(kOnMeridianM, y) : std::nullopt;
  if (!on_meridian) return x;
  const double off_deg = std::remainder(on_meridian->lon_deg - (6.0 * zoned->zone - 183.0), 360.0);
  return std::abs(off_deg) < kMeridianDeg ? zoned->east_m : x;
}

}  // namespace skyquilt::geo
