#include "core/simulate/world/sun_direction.h"

#include <cmath>
#include <ratio>

namespace skyquilt::simulate {

Eigen::Vector3d SunDirection(const geo::LatLon& place, std::chrono::sys_time<std::chrono::microseconds> utc) {
  constexpr std::chrono::sys_seconds kJ2000{std::chrono::seconds(946'728'000)};  // 2000-01-01 12:00
  const double days = std::chrono::duration<double, std::ratio<86'400>>(utc - kJ2000).count();
  const double mean_longitude_deg = 280.460 + 0.985'647'4 * days;
  const double anomaly_rad = geo::DegToRad(357.528 + 0.985'600'3 * days);
  const double ecliptic_longitude_rad =
      geo::DegToRad(mean_longitude_deg + 1.915 * std::sin(anomaly_rad) + 0.020 * std::sin(2.0 * anomaly_rad));
  const double obliquity_rad = geo::DegToRad(23.439 - 4e-7 * days);
  const double right_ascension_rad = std::atan2(std::cos(obliquity_rad) * std::sin(ecliptic_longitude_rad),
                                                std::cos(ecliptic_longitude_rad));
  const double declination_rad = std::asin(std::sin(obliquity_rad) * std::sin(ecliptic_longitude_rad));
  const double sidereal_deg = 15.0 * (18.697'374'558 + 24.065'709'824'419'08 * days) + place.lon_deg;
  const double hour_angle_rad = geo::DegToRad(sidereal_deg) - right_ascension_rad;
  const double lat_rad = geo::DegToRad(place.lat_deg);
  const double sin_dec = std::sin(declination_rad), cos_dec = std::cos(declination_rad);
  return {-cos_dec * std::sin(hour_angle_rad),
          sin_dec * std::cos(lat_rad) - cos_dec * std::cos(hour_angle_rad) * std::sin(lat_rad),
          sin_dec * std::sin(lat_rad) + cos_dec * std::cos(hour_angle_rad) * std::cos(lat_rad)};
}

}  // namespace skyquilt::simulate
