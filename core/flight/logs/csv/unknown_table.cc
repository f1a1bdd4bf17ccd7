#include "core/flight/logs/csv/unknown_table.h"

#include <fmt/core.h>

#include <algorithm>
#include <vector>

#include "core/flight/logs/csv/csv_columns.h"
#include "core/flight/logs/text_fields.h"

namespace skyquilt::flight {
namespace {

using M = CsvMeaning;

// Names in a sentence: few, short and printable.
std::string Listed(const std::vector<std::string>& names) {
  constexpr std::size_t kMaxNames = 8, kMaxLetters = 40;
  std::string words;
  for (std::size_t i = 0; i < std::min(names.size(), kMaxNames); ++i) {
    words += (i == 0 ? "" : ", ") + names[i].substr(0, kMaxLetters);
  }
  return names.size() > kMaxNames ? words + ", ..." : words;
}

bool IsRowOfNumbers(const std::vector<std::string_view>& cells, std::size_t columns) {
  if (cells.size() != columns) return false;
  const auto numbers = std::count_if(cells.begin(), cells.end(),
                                     [](std::string_view cell) { return ParseNumber(cell).has_value(); });
  return 2 * numbers >= static_cast<std::ptrdiff_t>(columns);
}

bool IsHeader(const std::vector<std::string_view>& cells) {
  return cells.size() >= 2 && std::all_of(cells.begin(), cells.end(), [](std::string_view cell) {
           return !cell.empty() && !ParseNumber(cell);
         });
}

}  // namespace

std::optional<std::string> ExplainUnknownTable(LogBytes head, std::string_view name) {
  constexpr int kRowsLookedAt = 20;
  constexpr int kRowsNeeded = 2;
  if (!LooksLikeText(TextOf(head))) return std::nullopt;
  LineReader lines(TextOf(head));
  std::string_view line;
  while (lines.Next(line)) {
    if (!Trim(line).empty() && line.front() != '#') break;
  }
  const char separator = GuessSeparator(line);
  std::vector<std::string_view> header, cells;
  SplitFields(line, separator, header);
  if (!IsHeader(header)) return std::nullopt;
  int rows = 0;
  for (int i = 0; i < kRowsLookedAt && rows < kRowsNeeded && lines.Next(line); ++i) {
    SplitFields(line, separator, cells);
    if (IsRowOfNumbers(cells, header.size())) ++rows;
  }
  if (rows < kRowsNeeded) return std::nullopt;

  const std::vector<CsvColumn> columns = MapTolerantColumns(header);
  bool has_time = false;
  std::vector<std::string> known, unknown;
  for (const CsvColumn& column : columns) {
    has_time = has_time || column.meaning == M::kTime || column.meaning == M::kUtc;
    (column.meaning == M::kIgnored ? unknown : known).push_back(column.header);
  }
  std::string words = fmt::format("{} is a table, but not used: ", name);
  words += has_time
               ? "beside the time it has no position, attitude, inertial samples or photo's name that is "
                 "recognised"
               : "no column of it is recognised as a time";
  if (!known.empty()) words += fmt::format("; recognised are {}", Listed(known));
  if (!unknown.empty()) words += fmt::format("; not recognised are {}", Listed(unknown));
  return words +
         ". Name its columns as in time_s, lat_deg, lon_deg, alt_m (positions) or time_s, photo (exposures).";
}

}  // namespace skyquilt::flight
