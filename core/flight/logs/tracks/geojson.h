// GeoJSON tracks: Features whose places have times, in a member `time`, `timestamp`, `datetime` and the like
// (one of a Point, as many as places of a line: coordTimes, times, datetimes), or in the fourth number of a
// place. The third number is taken for a height above mean sea level, which is what converters of GPX and KML
// write. Read as a stream: no document is built, 64 levels at most. Points in any order; t_s = 0 is the
// first. Any thread. Fails with kNoPosition where no place has a time, kCorrupt for what is no JSON. Source:
// RFC 7946, OGC Moving Features JSON (19-045r3), togeojson and kepler.gl for times.
#pragma once

#include "core/base/result.h"
#include "core/flight/bytes/log_bytes.h"
#include "core/flight/logs/flight_log.h"

namespace skyquilt::flight {

bool LooksLikeGeoJson(LogBytes head);

Result<FlightLog> ParseGeoJson(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed = {});

}  // namespace skyquilt::flight
