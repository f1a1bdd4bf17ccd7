// FlightCut: where a flight is cut into units, from its size alone, so that every process cuts alike. Pure.
#pragma once

#include <algorithm>
#include <cstddef>

namespace skyquilt::pipeline {

// From one number up to the next, of files or of blocks.
struct UnitRange {
  std::size_t first = 0;
  std::size_t end = 0;
};

// Large enough that starting a process is nothing beside it, small enough that a lost one costs little.
inline constexpr std::size_t kFilesPerLook = 200;
// More photos to a range are fewer photos decoded for two ranges; fewer are more processes at work.
inline constexpr std::size_t kLooksPerRender = 2;

inline std::size_t UnitsOf(std::size_t items, std::size_t per_unit) {
  return std::max<std::size_t>(1, (items + per_unit - 1) / per_unit);
}

// The unit's share of `items`, all of nearly the same size.
inline UnitRange RangeOf(std::size_t unit, std::size_t units, std::size_t items) {
  return {unit * items / units, (unit + 1) * items / units};
}

}  // namespace skyquilt::pipeline
