// OwnRecords: where photos were taken by their own word, for whoever compares or joins a list with it. Photos
// of one camera that share one place with others say nothing: the receiver repeats its last fix. Values;
// pure; any thread. Degrees (WGS84).
#pragma once

#include <optional>
#include <vector>

#include "core/flight/logs/flight_log.h"
#include "core/flight/photo.h"
#include "core/geo/lat_lon.h"

namespace skyquilt::poses {

// What photos say of themselves, and whether it moves with them.
struct OwnRecords {
  std::vector<std::optional<geo::LatLon>> moving;  // by photo
  std::optional<geo::LatLon> anywhere;             // of the flight
  bool is_of_photos = false;                       // what they say themselves, not a track or a list
  bool is_stale = false;
};

// `logs`: a track among them says where the flight was if the photos do not.
OwnRecords OwnRecordsOf(const std::vector<flight::Photo>& photos, const std::vector<flight::FlightLog>& logs);

}  // namespace skyquilt::poses
