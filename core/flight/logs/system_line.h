// The line above a list that names the reference system of its rows: alone in it, behind a word such as
// "CoordinateSystem:", or in brackets behind a name. Bounded work; any thread.
#pragma once

#include <optional>
#include <string_view>

#include "core/base/result.h"
#include "core/flight/bytes/text_fields.h"
#include "core/geo/crs/reference_system.h"

namespace skyquilt::flight {

struct SystemLine {
  std::string_view text;    // as geo::ReferenceSystem reads it; empty: the line names none
  bool is_certain = false;  // false: it may as well be the title of a table
};

// `lines` stands behind `line`, and is moved on over WKT that goes on below it.
SystemLine SystemOfLine(std::string_view line, LineReader& lines);

// Keeps the line in `system` where it is the better: what surely names one holds before what may be a title.
bool TakeSystem(const SystemLine& line, SystemLine& system);

// The system of the list `file`: nothing where no line names one, or what may be a title is none. Error:
// kUnsupportedFormat, for a line that is certain to name one that is not known.
Result<std::optional<geo::ReferenceSystem>> SystemOfList(std::string_view file, const SystemLine& line);

}  // namespace skyquilt::flight
