#include "core/flight/logs/csv/csv_units.h"

#include <array>
#include <vector>

#include "core/flight/bytes/text_fields.h"
#include "core/geo/lat_lon.h"

namespace skyquilt::flight {
namespace {

constexpr double kDeg = geo::kPi / 180.0;
// Names apart by '|', in lower case; "grad" is German for degrees, of "dms" the cell says so itself.
struct UnitNames {
  Dimension dimension;
  double factor;
  std::string_view names;
};
constexpr UnitNames kUnits[] = {
    {Dimension::kTime, 1.0, "s|sec|second|seconds"},
    {Dimension::kTime, 1e-3, "ms|msec|millisecond|milliseconds"},
    {Dimension::kTime, 1e-6, "us|usec|microseconds"},
    {Dimension::kTime, 1e-9, "ns|nsec|nanoseconds"},
    {Dimension::kLength, 1.0, "m|metre|metros|meter|meters|metres"},
    {Dimension::kLength, 1e-3, "mm"},
    {Dimension::kLength, 1e-2, "cm"},
    {Dimension::kLength, 0.3048, "ft|feet|foot|ift"},
    {Dimension::kLength, 1200.0 / 3937.0,
     "usft|us ft|ftus|sft|us survey feet|us survey foot|us survey ft|survey feet|survey ft|ft us|us feet"},
    {Dimension::kSpeed, 1.0, "m/s|mps"},
    {Dimension::kSpeed, 1e-2, "cm/s"},
    {Dimension::kSpeed, 0.44704, "mph"},
    {Dimension::kSpeed, 1.0 / 3.6, "km/h|kmh|kph"},
    {Dimension::kSpeed, 0.514444, "kn|knots"},
    {Dimension::kSpeed, 0.3048, "ft/s"},
    {Dimension::kAngle, kDeg, "deg|degrees|degree|\xC2\xB0|\xB0|decimal degrees"},
    {Dimension::kAngle, 1.0, "rad|radians|radian"},
    {Dimension::kAngle, 0.9 * kDeg, "gon|gons|gradians"},
    {Dimension::kRate, kDeg, "deg/s|dps|deg/sec"},
    {Dimension::kRate, 1.0, "rad/s|radps|rad/sec"},
    {Dimension::kRate, 1e-3, "mrad/s"},
    {Dimension::kAcceleration, 1.0, "m/s2|m/s^2|m/s/s|mps2"},
    {Dimension::kAcceleration, 9.80665, "g"},
    {Dimension::kAcceleration, 9.80665e-3, "mg"},
    {Dimension::kPressure, 1.0, "pa"},
    {Dimension::kPressure, 100.0, "hpa|mbar"},
    {Dimension::kPressure, 1000.0, "kpa"},
    {Dimension::kCoordinate, 1.0,
     "deg|degree|degrees|dd|\xC2\xB0|\xB0|decimal degrees|decimal|grad|dms|wgs 84|epsg:4326|wgs84"},
    {Dimension::kCoordinate, 1e-7, "e7|dege7|1e7"},
    {Dimension::kCoordinate, 1.0 / kDeg, "rad|radians"},
};

std::vector<CsvUnit> UnitsByName() {
  std::vector<CsvUnit> units;
  std::vector<std::string_view> names;
  for (const UnitNames& unit : kUnits) {
    SplitFields(unit.names, '|', names);
    for (const std::string_view name : names) units.push_back({name, unit.dimension, unit.factor});
  }
  return units;
}

}  // namespace

const CsvUnit* FindUnit(std::string_view name, Dimension dimension) {
  static const std::vector<CsvUnit> kByName = UnitsByName();
  for (const CsvUnit& unit : kByName) {
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
  return IsOneOf(behind, {"above sea level", "amsl", "asl", "msl"}) ? std::optional(unit->factor)
                                                                    : std::nullopt;
}

std::pair<double, std::string_view> DefaultUnit(Dimension dimension) {
  using Unit = std::pair<double, std::string_view>;
  constexpr std::array kUnitOf = {Unit{1.0, ""},     Unit{1.0, "s"},    Unit{1.0, "m"},
                                  Unit{1.0, "m/s"},  Unit{kDeg, "deg"}, Unit{1.0, "rad/s"},
                                  Unit{1.0, "m/s2"}, Unit{1.0, "Pa"},   Unit{1.0, "deg"}};
  static_assert(kUnitOf.size() == static_cast<std::size_t>(Dimension::kCoordinate) + 1);
  return kUnitOf[static_cast<std::size_t>(dimension)];
}

}  // namespace skyquilt::flight
