// What the columns of a CSV log mean, by synonyms and by the units that headers carry: "height(feet)", "acc_x
// [m/s^2]", "gyro_x_dps", "lonDeg", "LAT_DEG". Pure functions; any thread.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "core/flight/bytes/written_time.h"
#include "core/flight/logs/csv/csv_meanings.h"
#include "core/flight/logs/number_cell.h"
#include "core/flight/remarks/remark.h"

namespace skyquilt::flight {

struct CsvColumn {
  std::string header;  // as written, trimmed
  CsvMeaning meaning = CsvMeaning::kIgnored;
  double scale = 1.0;  // times this gives the unit above
  std::string unit;    // as understood, for the user
  bool unit_is_written = false;
  bool says_utc = false;
  bool counts_gps = false;      // GPS time; it says UTC then, as the leap seconds are taken off
  bool is_bare_height = false;  // "altitude", "z": the name does not say above what
  // Of a column that is ignored only because of words in its name: what it would be, and the words.
  CsvMeaning meant = CsvMeaning::kIgnored;
  std::string unknown_words;
  // What only the cells tell (settle_columns.h).
  DecimalMark mark = DecimalMark::kUnknown;
  DateOrder date_order = DateOrder::kYearFirst;
  bool is_elapsed_text = false;  // "0:12:05" or "12m 5s" as a time
};

// By a header that is not canonical. Several columns may have one meaning until SettleColumns sees cells.
std::vector<CsvColumn> MapTolerantColumns(const std::vector<std::string_view>& header);

// Whether a word beside a height says above what it counts: "ell", "nhn", "navd88".
bool IsZeroOfHeights(std::string_view word);

// The small letters and digits of a text.
std::string LettersAndDigits(std::string_view lower);

// The first column with this meaning; null where there is none.
template <typename Columns>
auto* ColumnOf(Columns& columns, CsvMeaning meaning) {
  const auto found = std::find_if(columns.begin(), columns.end(),
                                  [&](const CsvColumn& column) { return column.meaning == meaning; });
  return found == columns.end() ? nullptr : &*found;
}
inline bool HasColumn(const std::vector<CsvColumn>& columns, CsvMeaning meaning) {
  return ColumnOf(columns, meaning) != nullptr;
}

// Heights and angles that no column gives because words in the names of theirs are not known.
std::vector<Remark> SayUnknownWords(const std::vector<CsvColumn>& columns);

// "column -> meaning, unit" for each column that is used.
std::vector<std::string> DescribeColumns(const std::vector<CsvColumn>& columns);

}  // namespace skyquilt::flight
