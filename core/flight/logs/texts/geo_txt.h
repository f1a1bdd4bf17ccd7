// geo.txt of OpenDroneMap: a reference system in the first line, then "image x y [z [yaw pitch roll [sh
// sv]]]" per photo, x before y unless a line of column names says otherwise, degrees, pitch 0 = straight
// down, NaN for an angle that is not known; cut at blanks, tabs, semicolons or commas. Read and written. What
// the rows say is kept as written beside its plain reading; which reading is true, core/poses/lists judges,
// also of rows without a system. Angles counted from nadir are those of an airframe whose camera looks down,
// and are kept as such. Rows become camera events without a time; z is taken as a height above the ellipsoid.
// Any thread. Fails with kCorrupt when no row could be read, kUnsupportedFormat for an unknown reference
// system.
#pragma once

#include <span>
#include <string>

#include "core/base/result.h"
#include "core/flight/bytes/log_bytes.h"
#include "core/flight/logs/flight_log.h"

namespace skyquilt::flight {

bool LooksLikeGeoTxt(LogBytes head);

Result<FlightLog> ParseGeoTxt(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed = {});

// In EPSG:4326 with all digits. Only events with a name and a position are written; kInvalidArgument for a
// name with blanks, which the format cannot hold.
Result<std::string> WriteGeoTxt(std::span<const CameraEvent> events);

}  // namespace skyquilt::flight
