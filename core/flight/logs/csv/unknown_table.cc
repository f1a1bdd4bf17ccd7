#include "core/flight/logs/csv/unknown_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "core/flight/logs/coordinate_cell.h"
#include "core/flight/logs/csv/csv_columns.h"
#include "core/flight/logs/csv/unread_cells.h"
#include "core/flight/logs/text_fields.h"

namespace skyquilt::flight {
namespace {

using M = CsvMeaning;

constexpr std::size_t kMaxNamesSaid = 8;

// Names in a sentence: few, short and printable.
std::string Listed(const std::vector<std::string>& names) {
  std::string words;
  for (std::size_t i = 0; i < std::min(names.size(), kMaxNamesSaid); ++i)
    words += (i == 0 ? "" : ", ") + names[i];
  return names.size() > kMaxNamesSaid ? words + ", ..." : words;
}

bool IsMeasured(std::string_view cell) {
  return ReadNumberCell(cell) || ReadCoordinateCell(cell) || ParseDate(cell, DateOrder::kDayFirst) ||
         IsTimeOfDay(cell);
}

bool IsRowOfNumbers(const std::vector<std::string_view>& cells, std::size_t columns) {
  if (cells.size() != columns) return false;
  const auto numbers = std::count_if(cells.begin(), cells.end(), IsMeasured);
  return 2 * numbers >= static_cast<std::ptrdiff_t>(columns);
}

bool IsHeader(const std::vector<std::string_view>& cells) {
  return cells.size() >= 2 && std::all_of(cells.begin(), cells.end(), [](std::string_view cell) {
           return !cell.empty() && !ReadNumberCell(cell);
         });
}

// The columns by what they were taken for, those that were not with what stands in them.
struct TakenFor {
  std::vector<std::string> known, unknown;
  bool has_time = false, has_lat = false, has_lon = false;
};

TakenFor TakeColumns(const std::vector<std::string_view>& header, const std::vector<std::string_view>& row,
                     std::size_t line) {
  constexpr std::size_t kMaxLetters = 40, kValuesSaid = 3;
  TakenFor taken;
  const std::vector<CsvColumn> columns = MapTolerantColumns(header);
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const M meaning = columns[i].meaning;
    taken.has_time = taken.has_time || (meaning >= M::kTime && meaning <= M::kTimeOfDay);
    taken.has_lat = taken.has_lat || meaning == M::kLat;
    taken.has_lon = taken.has_lon || meaning == M::kLon;
    std::string name = columns[i].header.substr(0, kMaxLetters);
    if (meaning == M::kIgnored && taken.unknown.size() < kValuesSaid && i < row.size())
      name += fmt::format(" ({} in line {})", Quoted(row[i]), line);
    (meaning == M::kIgnored ? taken.unknown : taken.known).push_back(std::move(name));
  }
  return taken;
}

std::string_view WhatIsMissing(const TakenFor& taken) {
  if (taken.has_lat != taken.has_lon)
    return taken.has_lat ? "it has a latitude, but no column of it is recognised as a longitude"
                         : "it has a longitude, but no column of it is recognised as a latitude";
  if (!taken.has_time)
    return taken.has_lat ? "no column of it is recognised as a time, or as the names of photos"
                         : "no column of it is recognised as a time";
  return "beside the time it has no position, attitude, inertial samples or photo's name that is recognised";
}

}  // namespace

std::optional<std::string> ExplainUnknownTable(LogBytes head, std::string_view name) {
  constexpr int kRowsLookedAt = 20;
  constexpr int kMinRows = 2;
  if (!LooksLikeText(TextOf(head))) return std::nullopt;
  LineReader lines(TextOf(head));
  std::string_view line;
  while (lines.Next(line)) {
    if (!Trim(line).empty() && line.front() != '#' && !StartsWithIgnoringCase(line, "sep=")) break;
  }
  const std::string_view first_line = line;
  const std::size_t first_number = lines.line_number();
  const char separator = GuessSeparator(line);
  std::vector<std::string_view> header, cells, row;
  SplitFields(line, separator, header);
  const bool has_names = IsHeader(header);
  int rows = IsRowOfNumbers(header, header.size()) ? 1 : 0;
  if (header.size() < 2 || (!has_names && rows == 0)) return std::nullopt;
  std::size_t row_number = 0;
  for (int i = 0; i < kRowsLookedAt && rows < kMinRows && lines.Next(line); ++i) {
    SplitFields(line, separator, cells);
    if (!IsRowOfNumbers(cells, header.size())) continue;
    if (++rows > 1) continue;
    row = cells;
    row_number = lines.line_number();
  }
  if (rows < kMinRows) return std::nullopt;
  constexpr std::string_view kAdvice =
      "as in time_s, lat_deg, lon_deg, alt_m (positions), time_s, photo (exposures) or image, lat_deg, lon_deg, "
      "alt_m (photos).";
  if (!has_names) {
    return fmt::format(
        "{} is a table, but not used: line {}, {}, holds no names of columns and is no list that is read "
        "without them. Write names above it {}",
        name, first_number, Quoted(first_line), kAdvice);
  }
  const TakenFor taken = TakeColumns(header, row, row_number);
  std::string words = fmt::format("{} is a table, but not used: {}", name, WhatIsMissing(taken));
  if (!taken.known.empty()) words += fmt::format("; recognised are {}", Listed(taken.known));
  if (!taken.unknown.empty()) words += fmt::format("; not recognised are {}", Listed(taken.unknown));
  return words + fmt::format(". Name its columns {}", kAdvice);
}

}  // namespace skyquilt::flight
