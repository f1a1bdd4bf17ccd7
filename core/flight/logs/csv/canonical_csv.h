// The documented CSV pair. Any thread.
// flight.csv, sparse rows, any subset of: t (s) or utc (ISO 8601); wx wy wz (rad/s), ax ay az (m/s2, specific
// force, body x forward, y right, z down: at rest az = -9.81); qw qx qy qz (body to NED) or roll pitch yaw
// (deg); lat lon (deg), alt_ell or alt_msl (m), vn ve vd (m/s), sh sv (m, 1 sigma), fix (6 or "fixed": RTK);
// baro_alt (m) or press (Pa); range (m); rel_alt (m above take-off); event (image name or number).
// images.csv: image, t or utc, lat, lon, alt_ell, alt_msl, rel_alt, yaw pitch roll (deg, horizon zero, the
// camera's), sh, sv, s_rp, s_yaw (deg, 1 sigma). Its rows become camera events. Fails with kCorrupt when no
// row could be read.
#pragma once

#include "core/base/result.h"
#include "core/flight/bytes/log_bytes.h"
#include "core/flight/bytes/text_fields.h"
#include "core/flight/logs/csv/csv_columns.h"
#include "core/flight/logs/csv/settle_columns.h"
#include "core/flight/logs/flight_log.h"
#include "core/flight/logs/log_builder.h"

namespace skyquilt::flight {

bool LooksLikeFlightCsv(LogBytes head);
bool LooksLikeImagesCsv(LogBytes head);

Result<FlightLog> ParseFlightCsv(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed = {});
Result<FlightLog> ParseImagesCsv(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed = {});

// The rows below a header whose columns are known and settled; `builder` is empty and has the log's name and
// format.
Result<FlightLog> ReadImageRows(const std::vector<CsvColumn>& columns, const SettledColumns& settled,
                                char separator, LineReader lines, LogBuilder builder);

}  // namespace skyquilt::flight
