// The units that headers of CSV logs name, and their factors to ours. Pure functions; any thread.
#pragma once

#include <optional>
#include <string_view>
#include <utility>

namespace skyquilt::flight {

enum class Dimension {
  kNone,
  kTime,
  kLength,
  kSpeed,
  kAngle,
  kRate,
  kAcceleration,
  kPressure,
  kCoordinate  // latitude, longitude
};

struct CsvUnit {
  std::string_view name;  // lower case
  Dimension dimension;
  double factor;  // times this gives s, m, m/s, rad, rad/s, m/s2, Pa or, of coordinates, deg
};

// Null for a word that is no unit of this dimension.
const CsvUnit* FindUnit(std::string_view name, Dimension dimension);

// The factor of what stands behind a number in a cell: "ft", "m", "m Above Sea Level" (negative below it). Of
// coordinates none but degrees.
std::optional<double> FactorOfUnitBehind(std::string_view words, Dimension dimension);

// Factor and name for columns that do not name their unit.
std::pair<double, std::string_view> DefaultUnit(Dimension dimension);

}  // namespace skyquilt::flight
