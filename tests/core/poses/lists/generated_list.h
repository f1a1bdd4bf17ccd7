// GeneratedList: a file beside photos, in one of the many ways in which the world writes it, with the truth.
// Seeded; the same seed gives the same list. GeneratePositions: geo.txt and bare lists; GenerateTable: tables
// with headers; GenerateTrack: logs with times and events of the shutter; GenerateControl: surveyed points.
#pragma once

#include <optional>

#include "core/flight/photo.h"
#include "tests/core/poses/lists/list_parts.h"

namespace skyquilt::testing {

struct TruePlace {
  std::string name;  // of the photo, or of the surveyed point
  geo::Wgs84 at;
  bool has_row = true;  // false: the list leaves it out
};

struct GeneratedList {
  std::string file_name;
  std::string text;   // as a person reads it
  std::string bytes;  // the same in the encoding of the file
  std::vector<flight::Photo> photos;
  std::vector<TruePlace> truth;
  double tolerance_m = 1.0;
  // Between photos they must differ as the truth does; not asked for where the list has none, or where rows
  // are missing and another source's zero comes in.
  bool has_heights = false;
  bool is_of_another_flight = false;  // under the same names: must be said whatever becomes of it
  std::vector<std::string> causes;    // a refusal names one of them: a column, a system, a cell
};

GeneratedList GeneratePositions(std::uint32_t seed);
GeneratedList GenerateTable(std::uint32_t seed);
GeneratedList GenerateTrack(std::uint32_t seed);
GeneratedList GenerateControl(std::uint32_t seed);

// Twelve photos in three lines of different heights around a place, and what each of them says of itself: a
// position a few metres off where `with_positions`, else none.
void FlyOver(const geo::LatLon& middle, bool with_positions, Dice& dice, GeneratedList& list);

// For the file: leaves out a row now and then, and says so in the truth. How many rows are kept is at
// least 8.
void LoseRows(Dice& dice, GeneratedList& list);

}  // namespace skyquilt::testing
