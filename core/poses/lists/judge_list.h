// JudgeList: which way to read the two numbers of each row of a list. Every reading is a hypothesis: as
// written, the two exchanged, degrees where a system in metres is named, metres of the UTM zone of the photos
// where degrees are expected, west or south without a sign. Each is held against what else is known: whether
// its rows are places at all, of one flight, within the system's area of use (PROJ), how far they lie from
// the photos' own positions, and whether they are laid out as these. Without any other source the plain
// reading holds unless another fits and it does not. Cost: at most 2,000 rows are compared, one
// transformation a system. Pure; any thread.
#pragma once

#include <optional>
#include <vector>

#include "core/flight/lists/list_use.h"
#include "core/flight/logs/flight_log.h"
#include "core/geo/lat_lon.h"

namespace skyquilt::poses {

// A list before any reading of it is believed, and what the other sources say.
struct WrittenList {
  flight::ListUse use;                       // what is known before it is read
  bool order_is_assumed = false;             // neither by a header nor by the format
  std::vector<flight::WrittenPlace> rows;    // that are compared
  std::vector<flight::WrittenPlace> others;  // of photos that are not here: read as `rows` are
  // By row: where its photo says it was; nothing of photos that share their position with others, as they do
  // when a receiver has lost its fix. Empty for surveyed points, which lie beside the photos.
  std::vector<std::optional<geo::LatLon>> own_of_row;
  // Where the flight was, by other photos, a track, or a fix that all photos share; nothing: nobody knows.
  // Such a fix (`own_are_stale`) says roughly where, and refuses no list.
  std::optional<geo::LatLon> own_of_flight;
};

struct ListVerdict {
  flight::ListUse use;                // the reading, its fault, and how far it lies from what
  bool is_ambiguous = false;          // another reading is as likely: `other`, with its place
  std::optional<geo::LatLon> middle;  // of the list as it is read
  std::optional<flight::ListReading> other;
  std::optional<geo::LatLon> other_middle;
  std::optional<double> grid_north_rad;  // clockwise from true north, where places count in a plane
  std::vector<std::optional<geo::LatLon>> places, other_places;  // by row; empty with a fault
};

ListVerdict JudgeList(const WrittenList& list);

}  // namespace skyquilt::poses
