// AsEventList: a list of positions, one a camera event, that does not say so (RTKLIB's and Emlid's
// `_events.pos`, tables of a receiver that the shutter is wired to), as camera events. Told by its name where
// it holds no denser track, and otherwise by its rhythm: as many rows as photos, or within a few, at
// irregular times whose pattern is that of the photos' stamps, however wrong the camera's clock. Pure; any
// thread. A thousand rows cost some milliseconds.
#pragma once

#include <optional>
#include <vector>

#include "core/flight/logs/flight_log.h"
#include "core/flight/photo.h"

namespace skyquilt::poses {

// The log with its positions as events; nothing where it is a track, has other series, or fits no photos.
std::optional<flight::FlightLog> AsEventList(const flight::FlightLog& log,
                                             const std::vector<flight::Photo>& photos);

}  // namespace skyquilt::poses
