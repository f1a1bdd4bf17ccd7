// GPX tracks: every <trkpt> (else <wpt>) with a time becomes a GNSS sample; <ele> is a height above mean sea
// level. Scanned, not built into a tree, so that size does not matter. t_s = 0 is the first point. Any
// thread. Fails with kCorrupt when no point with position and time could be read.
#pragma once

#include "core/base/result.h"
#include "core/flight/logs/flight_log.h"
#include "core/flight/logs/log_bytes.h"

namespace skyquilt::flight {

bool LooksLikeGpx(LogBytes head);

Result<FlightLog> ParseGpx(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed = {});

}  // namespace skyquilt::flight
