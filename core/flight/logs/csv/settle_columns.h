// SettleColumns: what the cells of a table say about its columns beyond their names: which marks its decimals
// have, whether a column called "time" holds dates, times of day, elapsed times or numbers, whether dates
// have the day or the month first, and which of two columns with one meaning can be read. Pure; any thread.
// Looks at the first 5000 rows (16 MiB), and at all (64 MiB) where the order of dates asks for it; holds a
// few numbers a column.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/flight/bytes/text_fields.h"
#include "core/flight/logs/csv/csv_columns.h"
#include "core/flight/remarks/remark.h"

namespace skyquilt::flight {

struct SettledColumns {
  bool rows_name_photos = false;   // each one of its own, and say where it was taken
  bool rows_are_photos = false;    // and times, if any, are dates: no counter
  bool pitch_is_level = false;     // most lie near zero; for who reads other programs' rows to set
  std::vector<std::string> notes;  // for FlightLog::mapping
  std::vector<Remark> warnings;    // what was assumed
};

// `lines` stands below the header. Error: kUnprocessable where decimal commas cannot be told from the commas
// between cells, with the line.
Result<SettledColumns> SettleColumns(std::string_view name, LineReader lines, char separator,
                                     std::vector<CsvColumn>& columns);

}  // namespace skyquilt::flight
