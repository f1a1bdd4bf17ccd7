// ReadImageRows: a table whose rows name photos (images.csv, and such of other programs) as camera events.
// Any thread. Fails with kCorrupt when no row could be read.
#pragma once

#include "core/base/result.h"
#include "core/flight/bytes/text_fields.h"
#include "core/flight/logs/csv/csv_columns.h"
#include "core/flight/logs/csv/settle_columns.h"
#include "core/flight/logs/flight_log.h"
#include "core/flight/logs/log_builder.h"
#include "core/geo/crs/reference_system.h"

namespace skyquilt::flight {

// The rows below a header whose columns are known and settled; `builder` is empty and has the log's name and
// format. `system`: that a line above the header names, else null.
Result<FlightLog> ReadImageRows(const std::vector<CsvColumn>& columns, const SettledColumns& settled,
                                char separator, LineReader lines, LogBuilder builder,
                                const geo::ReferenceSystem* system = nullptr);

}  // namespace skyquilt::flight
