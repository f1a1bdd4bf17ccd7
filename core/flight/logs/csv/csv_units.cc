#include "core/flight/logs/csv/csv_units.h"

#include <algorithm>
#include <array>

#include "core/flight/bytes/text_fields.h"
#include "core/geo/lat_lon.h"

namespace skyquilt::flight {
namespace {

constexpr double kDeg = geo::kPi / 180.0;
constexpr std::array kUnits = {CsvUnit{"s", Dimension::kTime, 1.0},
                               CsvUnit{"sec", Dimension::kTime, 1.0},
                               CsvUnit{"second", Dimension::kTime, 1.0},
                               CsvUnit{"seconds", Dimension::kTime, 1.0},
                               CsvUnit{"ms", Dimension::kTime, 1e-3},
                               CsvUnit{"msec", Dimension::kTime, 1e-3},
                               CsvUnit{"millisecond", Dimension::kTime, 1e-3},
                               CsvUnit{"milliseconds", Dimension::kTime, 1e-3},
                               CsvUnit{"us", Dimension::kTime, 1e-6},
                               CsvUnit{"usec", Dimension::kTime, 1e-6},
                               CsvUnit{"microseconds", Dimension::kTime, 1e-6},
                               CsvUnit{"ns", Dimension::kTime, 1e-9},
                               CsvUnit{"nsec", Dimension::kTime, 1e-9},
                               CsvUnit{"nanoseconds", Dimension::kTime, 1e-9},
                               CsvUnit{"m", Dimension::kLength, 1.0},
                               CsvUnit{"metre", Dimension::kLength, 1.0},
                               CsvUnit{"metros", Dimension::kLength, 1.0},
                               CsvUnit{"meter", Dimension::kLength, 1.0},
                               CsvUnit{"meters", Dimension::kLength, 1.0},
                               CsvUnit{"metres", Dimension::kLength, 1.0},
                               CsvUnit{"mm", Dimension::kLength, 1e-3},
                               CsvUnit{"cm", Dimension::kLength, 1e-2},
                               CsvUnit{"ft", Dimension::kLength, 0.3048},
                               CsvUnit{"feet", Dimension::kLength, 0.3048},
                               CsvUnit{"foot", Dimension::kLength, 0.3048},
                               CsvUnit{"usft", Dimension::kLength, 1200.0 / 3937.0},
                               CsvUnit{"us ft", Dimension::kLength, 1200.0 / 3937.0},
                               CsvUnit{"ftus", Dimension::kLength, 1200.0 / 3937.0},
                               CsvUnit{"sft", Dimension::kLength, 1200.0 / 3937.0},
                               CsvUnit{"us survey feet", Dimension::kLength, 1200.0 / 3937.0},
                               CsvUnit{"us survey foot", Dimension::kLength, 1200.0 / 3937.0},
                               CsvUnit{"us survey ft", Dimension::kLength, 1200.0 / 3937.0},
                               CsvUnit{"survey feet", Dimension::kLength, 1200.0 / 3937.0},
                               CsvUnit{"survey ft", Dimension::kLength, 1200.0 / 3937.0},
                               CsvUnit{"ft us", Dimension::kLength, 1200.0 / 3937.0},
                               CsvUnit{"us feet", Dimension::kLength, 1200.0 / 3937.0},
                               CsvUnit{"ift", Dimension::kLength, 0.3048},
                               CsvUnit{"m/s", Dimension::kSpeed, 1.0},
                               CsvUnit{"mps", Dimension::kSpeed, 1.0},
                               CsvUnit{"cm/s", Dimension::kSpeed, 1e-2},
                               CsvUnit{"mph", Dimension::kSpeed, 0.44704},
                               CsvUnit{"km/h", Dimension::kSpeed, 1.0 / 3.6},
                               CsvUnit{"kmh", Dimension::kSpeed, 1.0 / 3.6},
                               CsvUnit{"kph", Dimension::kSpeed, 1.0 / 3.6},
                               CsvUnit{"kn", Dimension::kSpeed, 0.514444},
                               CsvUnit{"knots", Dimension::kSpeed, 0.514444},
                               CsvUnit{"ft/s", Dimension::kSpeed, 0.3048},
                               CsvUnit{"deg", Dimension::kAngle, kDeg},
                               CsvUnit{"degrees", Dimension::kAngle, kDeg},
                               CsvUnit{"degree", Dimension::kAngle, kDeg},
                               CsvUnit{"\xC2\xB0", Dimension::kAngle, kDeg},
                               CsvUnit{"\xB0", Dimension::kAngle, kDeg},
                               CsvUnit{"rad", Dimension::kAngle, 1.0},
                               CsvUnit{"radians", Dimension::kAngle, 1.0},
                               CsvUnit{"radian", Dimension::kAngle, 1.0},
                               CsvUnit{"decimal degrees", Dimension::kAngle, kDeg},
                               CsvUnit{"gon", Dimension::kAngle, 0.9 * kDeg},
                               CsvUnit{"gons", Dimension::kAngle, 0.9 * kDeg},
                               CsvUnit{"gradians", Dimension::kAngle, 0.9 * kDeg},
                               CsvUnit{"deg/s", Dimension::kRate, kDeg},
                               CsvUnit{"dps", Dimension::kRate, kDeg},
                               CsvUnit{"deg/sec", Dimension::kRate, kDeg},
                               CsvUnit{"rad/s", Dimension::kRate, 1.0},
                               CsvUnit{"radps", Dimension::kRate, 1.0},
                               CsvUnit{"rad/sec", Dimension::kRate, 1.0},
                               CsvUnit{"mrad/s", Dimension::kRate, 1e-3},
                               CsvUnit{"m/s2", Dimension::kAcceleration, 1.0},
                               CsvUnit{"m/s^2", Dimension::kAcceleration, 1.0},
                               CsvUnit{"m/s/s", Dimension::kAcceleration, 1.0},
                               CsvUnit{"mps2", Dimension::kAcceleration, 1.0},
                               CsvUnit{"g", Dimension::kAcceleration, 9.80665},
                               CsvUnit{"mg", Dimension::kAcceleration, 9.80665e-3},
                               CsvUnit{"pa", Dimension::kPressure, 1.0},
                               CsvUnit{"hpa", Dimension::kPressure, 100.0},
                               CsvUnit{"mbar", Dimension::kPressure, 100.0},
                               CsvUnit{"kpa", Dimension::kPressure, 1000.0},
                               CsvUnit{"deg", Dimension::kCoordinate, 1.0},
                               CsvUnit{"degree", Dimension::kCoordinate, 1.0},
                               CsvUnit{"degrees", Dimension::kCoordinate, 1.0},
                               CsvUnit{"dd", Dimension::kCoordinate, 1.0},
                               CsvUnit{"\xC2\xB0", Dimension::kCoordinate, 1.0},
                               CsvUnit{"\xB0", Dimension::kCoordinate, 1.0},
                               CsvUnit{"decimal degrees", Dimension::kCoordinate, 1.0},
                               CsvUnit{"decimal", Dimension::kCoordinate, 1.0},
                               CsvUnit{"grad", Dimension::kCoordinate, 1.0},  // German for degrees
                               CsvUnit{"dms", Dimension::kCoordinate, 1.0},   // the cell says so itself
                               CsvUnit{"wgs 84", Dimension::kCoordinate, 1.0},
                               CsvUnit{"epsg:4326", Dimension::kCoordinate, 1.0},
                               CsvUnit{"wgs84", Dimension::kCoordinate, 1.0},
                               CsvUnit{"e7", Dimension::kCoordinate, 1e-7},
                               CsvUnit{"dege7", Dimension::kCoordinate, 1e-7},
                               CsvUnit{"1e7", Dimension::kCoordinate, 1e-7},
                               CsvUnit{"rad", Dimension::kCoordinate, 1.0 / kDeg},
                               CsvUnit{"radians", Dimension::kCoordinate, 1.0 / kDeg}};

}  // namespace

const CsvUnit* FindUnit(std::string_view name, Dimension dimension) {
  for (const CsvUnit& unit : kUnits) {
    if (unit.name == name && unit.dimension == dimension) return &unit;
  }
  return nullptr;
}

std::optional<double> FactorOfUnitBehind(std::string_view words, Dimension dimension) {
  const std::string lower = LowerCase(Trim(words));
  if (const CsvUnit* unit = FindUnit(lower, dimension)) return unit->factor;
  if (dimension != Dimension::kLength) return std::nullopt;
  const std::size_t blank = lower.find(' ');
  const CsvUnit* unit = FindUnit(lower.substr(0, blank), dimension);
  if (unit == nullptr) return std::nullopt;
  const std::string_view behind = Trim(std::string_view(lower).substr(blank));
  if (behind == "below sea level") return -unit->factor;
  constexpr std::array<std::string_view, 4> kAboveTheSea = {"above sea level", "amsl", "asl", "msl"};
  const bool is_known = std::find(kAboveTheSea.begin(), kAboveTheSea.end(), behind) != kAboveTheSea.end();
  return is_known ? std::optional(unit->factor) : std::nullopt;
}

std::pair<double, std::string_view> DefaultUnit(Dimension dimension) {
  switch (dimension) {
    case Dimension::kTime:
      return {1.0, "s"};
    case Dimension::kLength:
      return {1.0, "m"};
    case Dimension::kSpeed:
      return {1.0, "m/s"};
    case Dimension::kAngle:
      return {kDeg, "deg"};
    case Dimension::kRate:
      return {1.0, "rad/s"};
    case Dimension::kAcceleration:
      return {1.0, "m/s2"};
    case Dimension::kPressure:
      return {1.0, "Pa"};
    case Dimension::kCoordinate:
      return {1.0, "deg"};
    case Dimension::kNone:
      return {1.0, ""};
  }
  return {1.0, ""};
}

}  // namespace skyquilt::flight
