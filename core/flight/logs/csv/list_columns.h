// What the columns of a list of photos mean: what those of logs do (csv_columns.h), and what lists alone
// have: coordinates in a plane, omega, phi and kappa, accuracies in the order of their columns. Also the line
// that names them: all lists with names of columns are read by these. Pure functions; any thread.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "core/flight/bytes/text_fields.h"
#include "core/flight/logs/csv/csv_columns.h"

namespace skyquilt::flight {

// Columns without a meaning in logs that have one in lists; the others as MapTolerantColumns has them.
std::vector<CsvColumn> MapListColumns(const std::vector<std::string_view>& header);

// By the names of the two coordinates.
PairOrder OrderOfPair(const std::vector<CsvColumn>& columns);

bool HasDegrees(const std::vector<CsvColumn>& columns);  // a latitude and a longitude
bool HasPlane(const std::vector<CsvColumn>& columns);    // an easting and a northing
bool NamesPhotos(const std::vector<CsvColumn>& columns);
bool HasPixels(const std::vector<CsvColumn>& columns);  // of marks that points have in photos

struct ListHeading {
  std::vector<CsvColumn> columns;
  char separator = ',';   // of the rows
  bool fits_row = false;  // the first one: it names a photo and says where that was
};

// The names of a list's columns: photos and where they are. `line` may begin with # and a word such as
// "columns:"; `below` stands behind it. Names that only blanks keep apart must all be known, or stand above a
// row of such cells: prose has such words too.
std::optional<ListHeading> ReadListHeading(std::string_view line, LineReader below);

}  // namespace skyquilt::flight
