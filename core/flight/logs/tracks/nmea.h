// NMEA 0183 recordings: GGA and GNS (position, fix, height and geoid separation), RMC (date; the position too
// where no sentence has a height), ZDA (date), GST (sigma), from any talker, alone in a line or behind what a
// recorder puts before it. Sentences with a wrong checksum are skipped and counted; without one they count.
// t_s = 0 is the first fix; UTC is known when a date was. Fails with kCorrupt when no fix could be read. Any
// thread.
#pragma once

#include "core/base/result.h"
#include "core/flight/bytes/log_bytes.h"
#include "core/flight/logs/flight_log.h"

namespace skyquilt::flight {

bool LooksLikeNmea(LogBytes head);

Result<FlightLog> ParseNmea(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed = {});

}  // namespace skyquilt::flight
