// Subtitles that DJI cameras write beside a video (.SRT), in their dialects: "GPS(lon,lat,satellites)", but
// "GPS(lat,lon,heightM)" where the third value carries an M; "[latitude : x] [longtitude : y]"; BAROMETER,
// Hb, H, rel_alt, abs_alt; F.PRY and G.PRY (pitch, roll, yaw in degrees). Fixes become GNSS samples whose
// sigma follows the digits written; t_s is the time in the video; the local clock is kept as local_at_zero.
// Any thread. Fails with kCorrupt for an empty file, kNoPosition when no subtitle holds a position.
#pragma once

#include "core/base/result.h"
#include "core/flight/logs/flight_log.h"
#include "core/flight/logs/log_bytes.h"

namespace skyquilt::flight {

bool LooksLikeDjiSrt(LogBytes head);

Result<FlightLog> ParseDjiSrt(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed = {});

}  // namespace skyquilt::flight
