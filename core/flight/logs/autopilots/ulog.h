// PX4 ULog (.ulg), versions 0 and 1: typed topics with nested types, appended data sections, drop-outs.
// sensor_combined, vehicle_attitude, vehicle_gps_position or sensor_gps (old integer and new double fields),
// vehicle_air_data or sensor_baro, distance_sensor, camera_capture (else camera_trigger). Of topics with
// several instances the first one is read. Time: microseconds since boot; UTC from time_utc_usec. Damage is
// skipped to the next sync mark and counted. Fails with kCorrupt when there is no data at all. Method: the
// ULog file format page of the PX4 guide. Any thread.
#pragma once

#include "core/base/result.h"
#include "core/flight/bytes/log_bytes.h"
#include "core/flight/logs/flight_log.h"

namespace skyquilt::flight {

bool LooksLikeUlog(LogBytes head);

Result<FlightLog> ParseUlog(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed = {});

}  // namespace skyquilt::flight
