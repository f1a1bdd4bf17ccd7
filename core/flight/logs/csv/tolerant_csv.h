// CSV logs of other makers (AirData, phone recorders, research rigs): columns are recognised by synonyms,
// units by what the headers say, and both are checked against physics: gravity for accelerations, the
// attitude column for angular rates, the step of the clock for times. The outcome is echoed in
// FlightLog::mapping; a unit that a header states and the numbers contradict is an error that names the
// column. A column of photos may hold flags, numbers or names: `time_s,photo` is a table of exposures; rows
// that name photos and say where they were taken, not when, become camera events without a time. What the
// cells say of their columns beyond the names, settle_columns.h finds; cells that cannot be read are told
// (unread_cells.h). Also the headerless replay rows "time_us,imu|gps|baro,values" of the PX4 estimator
// library. Fails with kCorrupt (no usable row), kUnprocessable (contradiction), kUnsupportedFormat (no column
// we know). Any thread.
#pragma once

#include "core/base/result.h"
#include "core/flight/bytes/log_bytes.h"
#include "core/flight/logs/flight_log.h"

namespace skyquilt::flight {

bool LooksLikeTolerantCsv(LogBytes head);
// A table whose names say which column is the image, the latitude and the longitude, but not in the order and
// units in which Pix4D's lists have them: what stands where is then read from the names.
bool LooksLikeNamedPlaces(LogBytes head);

Result<FlightLog> ParseTolerantCsv(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed = {});

}  // namespace skyquilt::flight
