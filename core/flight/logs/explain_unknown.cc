#include "core/flight/logs/explain_unknown.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "core/base/text/file_names.h"
#include "core/flight/bytes/text_fields.h"
#include "core/flight/logs/coordinate_cell.h"
#include "core/flight/logs/csv/csv_columns.h"
#include "core/flight/logs/csv/list_columns.h"
#include "core/flight/logs/csv/unread_cells.h"
#include "core/flight/logs/formats.h"
#include "core/flight/logs/texts/list_rows.h"

namespace skyquilt::flight {
namespace {

using M = CsvMeaning;

constexpr std::size_t kMaxNamesSaid = 8;

// Names in a sentence: few, short and printable.
std::string Listed(const std::vector<std::string>& names, std::size_t most) {
  std::string words;
  for (std::size_t i = 0; i < std::min(names.size(), most); ++i) words += (i == 0 ? "" : ", ") + names[i];
  return names.size() > most ? words + ", ..." : words;
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

// The columns by what they were taken for.
struct TakenFor {
  std::vector<std::string> known;
  std::vector<Remark> shown;         // of those that were taken for nothing, with what stands in them
  std::vector<std::string> unknown;  // the others of them
  bool has_time = false, has_lat = false, has_lon = false, names_photos = false;
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
    taken.names_photos = taken.names_photos || meaning == M::kImage;
    std::string name = columns[i].header.substr(0, kMaxLetters);
    if (meaning != M::kIgnored) {
      taken.known.push_back(std::move(name));
    } else if (taken.shown.size() < kValuesSaid && i < row.size()) {
      taken.shown.push_back({taken.shown.empty() ? RemarkCode::kColumnShown : RemarkCode::kAndColumnShown,
                             {{"column", std::move(name)}, {"cell", Quoted(row[i])}, {"line", line}}});
    } else {
      taken.unknown.push_back(std::move(name));
    }
  }
  return taken;
}

std::vector<Remark> WhatIsKnown(TakenFor taken) {
  std::vector<Remark> said;
  if (!taken.known.empty())
    said.push_back({RemarkCode::kColumnsKnown, {{"columns", Listed(taken.known, kMaxNamesSaid)}}});
  const std::string others = Listed(taken.unknown, kMaxNamesSaid - taken.shown.size());
  if (!taken.shown.empty() && !others.empty()) {
    said.push_back({RemarkCode::kColumnsUnknownAndMore,
                    {{"columns", std::move(taken.shown)}, {"more_columns", others}}});
  } else if (!taken.shown.empty()) {
    said.push_back({RemarkCode::kColumnsUnknown, {{"columns", std::move(taken.shown)}}});
  } else if (!others.empty()) {
    said.push_back({RemarkCode::kColumnsUnknown, {{"columns", others}}});
  }
  return said;
}

// `names_places`: columns of a survey, such as easting and northing.
RemarkCode WhatIsMissing(const TakenFor& taken, bool names_places) {
  if (taken.has_lat != taken.has_lon)
    return taken.has_lat ? RemarkCode::kLacksLongitude : RemarkCode::kLacksLatitude;
  if (taken.names_photos && !taken.has_lat) return RemarkCode::kLacksPlace;
  if (!taken.has_time)
    return taken.has_lat || names_places ? RemarkCode::kLacksTimeOrNames : RemarkCode::kLacksTime;
  return RemarkCode::kLacksWhatIsTimed;
}

constexpr std::size_t kCellsOfPoint = 5;  // x y z pixel_x pixel_y, before the photo's name

struct BadCell {
  std::size_t column = 0;  // from 1
  std::string_view cell;   // empty: the row ends before it
};

// The first of `count` cells from `begin` that is no number.
std::optional<BadCell> FirstBadCell(const std::vector<std::string_view>& cells, std::size_t begin,
                                    std::size_t count) {
  for (std::size_t i = begin; i < begin + count; ++i) {
    if (i >= cells.size()) return BadCell{i + 1, {}};
    if (!ParseListCoordinate(cells[i])) return BadCell{i + 1, cells[i]};
  }
  return std::nullopt;
}

Remark Explained(RemarkCode list, std::string_view name, std::size_t line_number, const BadCell& bad) {
  Remark what = RemarkCode::kCellMissing;
  if (!bad.cell.empty()) what = {RemarkCode::kCellNoNumber, {{"cell", Quoted(bad.cell)}}};
  return {list, {{"file", name}, {"column", bad.column}, {"line", line_number}, {"what", std::move(what)}}};
}

}  // namespace

std::optional<Remark> ExplainUnknownTable(LogBytes head, std::string_view name) {
  constexpr int kRowsLookedAt = 20;
  constexpr int kMinRows = 2;
  if (!LooksLikeText(TextOf(head))) return std::nullopt;
  LineReader lines(TextOf(head));
  std::string_view line, comment;
  while (lines.Next(line)) {
    if (Trim(line).empty() || StartsWithIgnoringCase(line, "sep=")) continue;
    if (line.front() != '#') break;
    comment = line.substr(std::min(line.find_first_not_of("# \t"), line.size()));
  }
  const std::string_view first_line = line;
  const std::size_t first_number = lines.line_number();
  const char separator = GuessSeparator(line);
  std::vector<std::string_view> header, cells, row;
  SplitFields(line, separator, header);
  bool has_names = IsHeader(header);
  int rows = IsRowOfNumbers(header, header.size()) ? 1 : 0;
  if (header.size() < 2 || (!has_names && rows == 0)) return std::nullopt;
  std::size_t row_number = 0;
  SplitFields(comment, separator, cells);
  if (!has_names && cells.size() == header.size() && IsHeader(cells)) {  // the names are commented out
    row = std::exchange(header, cells);
    row_number = first_number;
    has_names = true;
  }
  for (int i = 0; i < kRowsLookedAt && rows < kMinRows && lines.Next(line); ++i) {
    SplitFields(line, separator, cells);
    if (!IsRowOfNumbers(cells, header.size())) continue;
    if (++rows > 1) continue;
    row = cells;
    row_number = lines.line_number();
  }
  if (rows < kMinRows) return std::nullopt;
  if (!has_names) {
    return Remark{RemarkCode::kTableWithoutNames,
                  {{"file", name}, {"line", first_number}, {"text", Quoted(first_line)}}};
  }
  if (HasPixels(MapTolerantColumns(header))) {
    if (const auto bad = FirstBadCell(row, 0, kCellsOfPoint))
      return Explained(RemarkCode::kLikeListOfPoints, name, row_number, *bad);
  }
  TakenFor taken = TakeColumns(header, row, row_number);
  const Remark missing = WhatIsMissing(taken, OrderOfColumns(header).has_value());
  return Remark{RemarkCode::kTableLacks,
                {{"file", name}, {"missing", missing}, {"columns", WhatIsKnown(std::move(taken))}}};
}

namespace {

// The name of a row that is one of several words only if they are no prose: quotes would tell.
bool WantsQuotes(std::string_view line, std::string_view name) {
  return name.find(' ') != std::string_view::npos && line.find_first_of("\",;\t") == std::string_view::npos;
}

}  // namespace

std::optional<Remark> ExplainUnknownList(LogBytes head, std::string_view name) {
  constexpr int kLinesLookedAt = 24;
  if (!LooksLikeText(TextOf(head))) return std::nullopt;
  LineReader lines(TextOf(head));
  std::string_view line;
  std::vector<std::string_view> cells;
  const auto names_a_photo = [](const std::vector<std::string_view>& row) {
    return row.size() >= 2 && std::any_of(row.begin(), row.end(), IsNamedAsPicture);
  };
  for (int i = 0; i < kLinesLookedAt && lines.Next(line); ++i) {
    if (IsBlankOrComment(line) || !SplitListRow(line, names_a_photo, cells)) continue;
    const auto photo = std::find_if(cells.begin(), cells.end(), IsNamedAsPicture);
    if (photo == cells.begin()) {
      const auto bad = FirstBadCell(cells, 1, 2);
      if (bad) return Explained(RemarkCode::kLikeListOfPlaces, name, lines.line_number(), *bad);
    } else if (static_cast<std::size_t>(photo - cells.begin()) <= kCellsOfPoint) {
      const auto bad = FirstBadCell(cells, 0, kCellsOfPoint);
      if (bad) return Explained(RemarkCode::kLikeListOfPoints, name, lines.line_number(), *bad);
    } else {
      continue;
    }
    if (WantsQuotes(line, *photo))
      return Remark{RemarkCode::kNameWantsQuotes,
                    {{"file", name}, {"line", lines.line_number()}, {"name", Quoted(*photo)}}};
  }
  return std::nullopt;
}

namespace {

struct NamedTrack {
  std::string_view ending;
  RemarkCode lacks;  // the mark by which it is known
};

constexpr std::array<NamedTrack, 6> kNamedTracks = {{
    {".gpx", RemarkCode::kNamedAsGpx},
    {".kml", RemarkCode::kNamedAsKml},
    {".geojson", RemarkCode::kNamedAsGeojson},
    {".nmea", RemarkCode::kNamedAsNmea},
    {".srt", RemarkCode::kNamedAsSrt},
    {".ass", RemarkCode::kNamedAsAss},
}};

}  // namespace

std::optional<Remark> ExplainUnknownTrack(LogBytes head, std::string_view name) {
  constexpr std::size_t kQuotedLine = 60;
  const std::string lower = LowerCase(name);
  if (lower.ends_with(".kmz")) return Remark{RemarkCode::kKmzNotRead, {{"file", name}}};
  if (lower.ends_with(".geojson") && HasGeoJsonAreas(head))
    return Remark{RemarkCode::kAreasNoTrack, {{"file", name}}};
  const auto named = std::find_if(kNamedTracks.begin(), kNamedTracks.end(),
                                  [&](const NamedTrack& track) { return lower.ends_with(track.ending); });
  if (named == kNamedTracks.end()) return std::nullopt;
  Remark begins = RemarkCode::kFirstBytesNoText;
  if (LooksLikeText(TextOf(head))) {
    const std::string_view text = Trim(TextOf(head));
    begins = {RemarkCode::kFirstLineIs,
              {{"text", Quoted(text.substr(0, text.find_first_of("\r\n")), kQuotedLine)}}};
  }
  return Remark{named->lacks, {{"file", name}, {"begins", std::move(begins)}}};
}

}  // namespace skyquilt::flight
