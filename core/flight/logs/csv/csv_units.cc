#include "core/flight/logs/csv/csv_units.h"

#include <array>

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
                               CsvUnit{"meter", Dimension::kLength, 1.0},
                               CsvUnit{"meters", Dimension::kLength, 1.0},
                               CsvUnit{"metres", Dimension::kLength, 1.0},
                               CsvUnit{"mm", Dimension::kLength, 1e-3},
                               CsvUnit{"cm", Dimension::kLength, 1e-2},
                               CsvUnit{"ft", Dimension::kLength, 0.3048},
                               CsvUnit{"feet", Dimension::kLength, 0.3048},
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
                               CsvUnit{"rad", Dimension::kAngle, 1.0},
                               CsvUnit{"radians", Dimension::kAngle, 1.0},
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
