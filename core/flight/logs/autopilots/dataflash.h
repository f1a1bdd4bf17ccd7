// ArduPilot DataFlash logs (.BIN, and .log where they were converted to text): self-describing binary
// messages, 0xA3 0x95 id. The FMT messages (id 128) name the fields of all others, so old and new layouts are
// read alike. IMU, ATT (else AHR2, XKF1, NKF1, EKF1), GPS with GPA (else POS), BARO, RFND, CAM (else TRIG).
// Where a sensor is there more than once, one instance serves the whole run: the IMU with the fewest clips,
// the GPS with the best fix. Time: TimeUS (old: TimeMS) since boot; UTC from the GPS week and its leap
// seconds. Damaged parts are skipped and counted; fails with kCorrupt only when no message could be read.
// Method: "DataFlash logs" of the ArduPilot documentation and AP_Logger's list of format characters. Any
// thread.
#pragma once

#include "core/base/result.h"
#include "core/flight/bytes/log_bytes.h"
#include "core/flight/logs/flight_log.h"

namespace skyquilt::flight {

bool LooksLikeDataflash(LogBytes head);

Result<FlightLog> ParseDataflash(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed = {});

// The same of what LooksLikeDataflashText (dataflash_text.h).
Result<FlightLog> ParseDataflashText(std::string_view name, LogBytes bytes,
                                     const ConsumedUpTo& consumed = {});

}  // namespace skyquilt::flight
