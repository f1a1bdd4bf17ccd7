// geoinfo files of senseFly: "#Rev: sensefly/geoinfo", a header, then tab-separated rows with file name,
// latitude, longitude, altitude_amsl, altitude_wgs84, heading, pitch, roll of the airframe in degrees. Rows
// become camera events without a time. Fails with kCorrupt when no row could be read. Any thread.
#pragma once

#include "core/base/result.h"
#include "core/flight/bytes/log_bytes.h"
#include "core/flight/logs/flight_log.h"

namespace skyquilt::flight {

bool LooksLikeSenseflyGeoinfo(LogBytes head);

Result<FlightLog> ParseSenseflyGeoinfo(std::string_view name, LogBytes bytes,
                                       const ConsumedUpTo& consumed = {});

}  // namespace skyquilt::flight
