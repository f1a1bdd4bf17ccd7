// Latitudes and longitudes as people and programs write them in the cells of lists: plain, with decimal
// commas, with degrees, minutes and seconds, with letters of the hemisphere. UTF-8 and Latin-1. Pure; any
// thread. Nothing for what cannot be read or could be read in two ways; cells of more than 64 bytes are none.
// Whether a coordinate lies on the Earth is the caller's to check.
#pragma once

#include <optional>
#include <string_view>

#include "core/flight/logs/number_cell.h"

namespace skyquilt::flight {

struct CoordinateCell {
  double value = 0.0;   // degrees where the cell says so, else as written; negative for S and W
  char hemisphere = 0;  // 'N', 'S', 'E', 'W' where one is written
};

// "46.8426", "46,8426", "-92.0", "N46.8426", "92.0W", "46.84°", "46°50'33.39\"", "N46°50'33,39\"",
// "46 50 33.39 N", "46:50:33.39", "46d50m33.39s N", "46 deg 50' 33.39\" N", with typographic marks too.
// Minutes and seconds are below 60; a minus before N or E contradicts them.
std::optional<CoordinateCell> ReadCoordinateCell(std::string_view cell);

}  // namespace skyquilt::flight
