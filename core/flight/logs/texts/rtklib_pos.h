// Solutions of RTKLIB and its kin (.pos): "%" header, then date and time or GPS week and seconds, latitude,
// longitude (degrees, or degrees minutes seconds), ellipsoidal height, quality (1 fixed), satellites, sigma
// north, east, up. Also its ECEF form. Times are GPS time or UTC as the header says; positions are the
// ANTENNA's. t_s = 0 is the first solution. Fails with kCorrupt when no solution could be read. Any thread.
#pragma once

#include "core/base/result.h"
#include "core/flight/bytes/log_bytes.h"
#include "core/flight/logs/flight_log.h"

namespace skyquilt::flight {

bool LooksLikeRtklibPos(LogBytes head);

Result<FlightLog> ParseRtklibPos(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed = {});

}  // namespace skyquilt::flight
