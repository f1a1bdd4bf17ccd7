// MAVLink telemetry logs (.tlog), protocol 1 and 2: each packet behind an 8-byte big-endian Unix time in
// microseconds, taken by the ground station's clock. The vehicle's own clock (time_boot_ms) times the
// samples, so that the jitter of the radio link does not; UTC comes from SYSTEM_TIME where the vehicle knows
// it, else from the ground station. GPS_RAW_INT (else GLOBAL_POSITION_INT), ATTITUDE, HIGHRES_IMU,
// DISTANCE_SENSOR or RANGEFINDER, MOUNT_ORIENTATION, CAMERA_FEEDBACK, CAMERA_IMAGE_CAPTURED, CAMERA_TRIGGER.
// The vehicle with the most ATTITUDE messages is read. Known messages must pass their checksum. Fails with
// kCorrupt when no packet could be read. Method: mavlink.io, "Packet Serialization" and common.xml. Any
// thread.
#pragma once

#include "core/base/result.h"
#include "core/flight/bytes/log_bytes.h"
#include "core/flight/logs/flight_log.h"

namespace skyquilt::flight {

bool LooksLikeMavlinkTlog(LogBytes head);

Result<FlightLog> ParseMavlinkTlog(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed = {});

}  // namespace skyquilt::flight
