// The line above a list that names the reference system of its rows: alone in it, behind a word such as
// "CoordinateSystem:", or in brackets behind a name. Bounded work; any thread.
#pragma once

#include <string_view>

#include "core/base/result.h"
#include "core/flight/bytes/text_fields.h"

namespace skyquilt::flight {

struct SystemLine {
  std::string_view text;    // as geo::ReferenceSystem reads it; empty: the line names none
  bool is_certain = false;  // false: it may as well be the title of a table
};

// `lines` stands behind `line`, and is moved on over WKT that goes on below it.
SystemLine SystemOfLine(std::string_view line, LineReader& lines);

// Of the list `file`, whose line `system` names no reference system that is known.
Error SystemUnknown(std::string_view file, std::string_view system);

}  // namespace skyquilt::flight
