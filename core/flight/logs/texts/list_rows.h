// Lists below a line that names their reference system (geo.txt, control points): what stands above the rows,
// and rows cut at whatever separates them: tabs, semicolons, commas or blanks; numbers may have a decimal
// comma where commas do not separate. Bounded like text_fields.h; any thread.
#pragma once

#include <functional>
#include <optional>
#include <string_view>
#include <vector>

#include "core/flight/bytes/text_fields.h"
#include "core/flight/logs/number_cell.h"

namespace skyquilt::flight {

// A coordinate, also with degrees, minutes and seconds or a letter of the hemisphere.
std::optional<double> ParseListCoordinate(std::string_view cell);

// A file name with an ending, and no number.
bool LooksLikeImageName(std::string_view word);

using IsListRow = std::function<bool(const std::vector<std::string_view>& cells)>;

// Cuts the line so that it is a row; at blanks, and false, where no way of cutting makes it one. A picture's
// name in it may hold blanks, in quotes, between numbers or where the row begins.
bool SplitListRow(std::string_view line, const IsListRow& is_row, std::vector<std::string_view>& cells);

struct ListTop {
  std::string_view system;                // the line that names it, or WKT over several; empty: none does
  std::vector<std::string_view> columns;  // their names; empty: none are named
  std::vector<std::string_view> row;      // the first
  std::string_view row_line;
  bool name_is_joined = false;  // a picture's, of words without quotes: prose that names one reads so too
  std::vector<std::size_t> skipped_lines;  // above the first row, that are none of these
  std::size_t row_number = 0;              // of the line, from 1
  std::size_t row_offset = 0;              // of the text behind that line
};

// Nothing where no row stands among the first lines.
std::optional<ListTop> ReadListTop(std::string_view text, const IsListRow& is_row);

// Names of columns, however they are separated: two that are known at least, and no numbers; else nothing.
std::vector<std::string_view> ColumnNames(std::string_view line);

// Three of such names are known, or half: no title, whose words may be names by chance.
bool AreNamesOfColumns(const std::vector<std::string_view>& columns);

// The order that names of columns give a pair of coordinates; nothing where none, or "x" and "y", do.
enum class NamedOrder { kEastFirst, kNorthFirst };
std::optional<NamedOrder> OrderOfColumns(const std::vector<std::string_view>& columns);

// The order that the letters of the hemispheres tell, as in "N46.8", "8.1 E"; nothing without them.
std::optional<NamedOrder> OrderOfLetters(std::string_view first, std::string_view second);

}  // namespace skyquilt::flight
