// KML tracks: gx:Track (the k-th <when> and the k-th <gx:coord> are a point) and Placemarks with a TimeStamp
// and a Point. Heights are above mean sea level; above the place of take-off where altitudeMode is relative,
// which is how flight apps write it; none where it is clamped. Any prefix of a namespace, points in any
// order. t_s = 0 is the first point. Any thread. Fails with kNoPosition where no point has position and time,
// as in the lines and areas that KML mostly holds. Source: OGC KML 2.3 (12-007r2), Google's extensions.
#pragma once

#include "core/base/result.h"
#include "core/flight/bytes/log_bytes.h"
#include "core/flight/logs/flight_log.h"

namespace skyquilt::flight {

bool LooksLikeKml(LogBytes head);

Result<FlightLog> ParseKml(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed = {});

}  // namespace skyquilt::flight
