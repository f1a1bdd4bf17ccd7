#include "core/flight/logs/texts/unknown_list.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "core/flight/bytes/text_fields.h"
#include "core/flight/logs/texts/list_rows.h"

namespace skyquilt::flight {
namespace {

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

std::optional<Remark> ExplainUnknownList(LogBytes head, std::string_view name) {
  constexpr int kLinesLookedAt = 24;
  if (!LooksLikeText(TextOf(head))) return std::nullopt;
  LineReader lines(TextOf(head));
  std::string_view line;
  std::vector<std::string_view> cells;
  const auto names_a_photo = [](const std::vector<std::string_view>& row) {
    return row.size() >= 2 && std::any_of(row.begin(), row.end(), LooksLikePhotoFile);
  };
  for (int i = 0; i < kLinesLookedAt && lines.Next(line); ++i) {
    if (Trim(line).empty() || line.front() == '#' || !SplitListRow(line, names_a_photo, cells)) continue;
    const auto photo = std::find_if(cells.begin(), cells.end(), LooksLikePhotoFile);
    if (photo == cells.begin()) {
      const auto bad = FirstBadCell(cells, 1, 2);
      if (bad) return Explained(RemarkCode::kLikeListOfPlaces, name, lines.line_number(), *bad);
    } else if (static_cast<std::size_t>(photo - cells.begin()) <= kCellsOfPoint) {
      const auto bad = FirstBadCell(cells, 0, kCellsOfPoint);
      if (bad) return Explained(RemarkCode::kLikeListOfPoints, name, lines.line_number(), *bad);
    }
  }
  return std::nullopt;
}

}  // namespace skyquilt::flight
