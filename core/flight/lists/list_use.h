// ListUse: what was made of one list that was given, be it of positions or of surveyed points: as what it was
// read, how many of its rows serve, how far it lies from the photos' own positions, or why it does not serve.
// A value; core/poses/lists makes it and has its words. Degrees and metres as named; any thread.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

namespace skyquilt::flight {

// What the two numbers of a row count in.
enum class CountsIn {
  kSystem,       // the system that the list names
  kDegrees,      // longitude and latitude
  kUtmOfFlight,  // metres of the UTM zone in which the photos lie by their own positions
};

// One way to read a list. The plain one: in the named system (in degrees without one), nothing turned round.
struct ListReading {
  CountsIn counts_in = CountsIn::kDegrees;
  bool is_swapped = false;  // what stands for east is north, and the other way round
  bool west_is_positive = false;
  bool south_is_positive = false;
  int utm_code = 0;  // of EPSG, of kUtmOfFlight

  bool operator==(const ListReading&) const = default;
};

enum class ListFault {
  kNone,
  kNamesNoPhoto,
  kNoSystem,     // metres, and nothing says of which system
  kNoPlace,      // no reading makes most rows places of one flight
  kFarAway,      // every reading lies further from the photos' own positions than receivers err
  kOtherShape,   // near enough, but laid out otherwise: rows of another flight, or names in another order
  kOtherTime,    // its times are days from the photos'
  kOtherPixels,  // marks of surveyed points lie outside their photos
};

enum class ListKind { kPositions, kControl };

struct ListUse {
  ListKind kind = ListKind::kPositions;
  std::string file_name;
  std::string format;
  std::string system;  // as written; empty: none
  bool order_is_named = false;
  ListReading reading;
  bool is_as_written = true;  // `reading` is the plain one
  bool is_in_area = true;     // within the system's area of use
  std::size_t rows = 0;
  std::size_t rows_used = 0;  // 0 where it does not serve; without those in whose place others hold
  std::string held_by;        // the list whose rows hold in place of some of these; empty: none
  // What the system's own place on Earth is known to; nothing: to a metre or better.
  std::optional<double> system_error_m;
  bool lacks_grid = false;  // which would tell it better
  // The step in which all its coordinates are written, where that is worse than what rows claim.
  std::optional<double> rounded_to_m;
  std::size_t marks = 0, marks_outside = 0;  // of surveyed points, in photos of the flight
  std::optional<double> apart_m;             // median, of the reading, to the photos' own positions
  std::optional<double> as_written_apart_m;  // likewise, of the plain reading
  std::optional<double> off_shape_m;         // median, after the median shift
  std::optional<double> shifted_m;           // what all its rows share of `apart_m`, at least
  std::optional<double> apart_days;  // median of its times and the photos', where no clock errs so much
  bool own_are_photos = false;       // their own positions were compared with; else tracks, other lists
  bool own_are_stale = false;        // most of the photos' own positions are one and the same
  // Nothing but the order that the format documents speaks against the other order of the two numbers, which
  // would put the list so far away.
  std::optional<double> other_order_apart_m;
  ListFault fault = ListFault::kNone;
};

}  // namespace skyquilt::flight
