// GPX: every point with a time becomes a GNSS sample: those of tracks, else of routes, else waypoints. <ele>
// is a height above mean sea level, <geoidheight> what the ellipsoid lies below it. Any prefix of the
// namespace, points in any order. Scanned, not built into a tree, so that size does not matter. t_s = 0 is
// the first point. Any thread. Fails with kNoPosition when no point with position and time could be read.
// Source: GPX 1.1 (topografix.com).
#pragma once

#include "core/base/result.h"
#include "core/flight/bytes/log_bytes.h"
#include "core/flight/logs/flight_log.h"

namespace skyquilt::flight {

bool LooksLikeGpx(LogBytes head);

Result<FlightLog> ParseGpx(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed = {});

}  // namespace skyquilt::flight
