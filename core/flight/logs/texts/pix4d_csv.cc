#include <cmath>
#include <optional>

#include "core/base/text/file_names.h"
#include "core/base/text/printable.h"
#include "core/flight/bytes/text_fields.h"
#include "core/flight/logs/formats.h"
#include "core/flight/logs/log_builder.h"
#include "core/flight/logs/texts/list_rows.h"

namespace skyquilt::flight {
namespace {

bool IsRow(const std::vector<std::string_view>& cells) {
  return cells.size() >= 4 && cells.size() <= 12 && IsNamedAsPicture(cells[0]) &&
         ParseListCoordinate(cells[1]) && ParseListCoordinate(cells[2]) && ReadBareNumber(cells[3]);
}

bool IsInDegrees(double first, double second) {
  return std::abs(first) <= 180.0 && std::abs(second) <= 180.0;
}

// By the number of columns: angles in columns five to seven, whichever they are, then the accuracies.
std::size_t AccuracyColumn(std::size_t count) { return count >= 9 ? 7 : (count == 6 ? 4 : 0); }

WrittenPlace PlaceOfCells(double first, double second, std::optional<NamedOrder> order) {
  const bool is_north_first = order ? *order == NamedOrder::kNorthFirst : IsInDegrees(first, second);
  return is_north_first ? WrittenPlace{second, first} : WrittenPlace{first, second};
}

}  // namespace

bool LooksLikePix4dCsv(LogBytes head) {
  LineReader lines(TextOf(head));
  std::string_view line;
  std::vector<std::string_view> cells;
  for (int i = 0; i < 8 && lines.Next(line); ++i) {
    if (Trim(line).empty()) continue;
    SplitFields(line, GuessSeparator(line), cells);
    if (IsRow(cells)) return true;
    if (line.front() != '#' || AreNamesOfColumns(ColumnNames(line))) return false;
  }
  return false;
}

Result<FlightLog> ParsePix4dCsv(std::string_view name, LogBytes bytes, const ConsumedUpTo&) {
  LogBuilder builder("pix4d_csv", name);
  LineReader lines(TextOf(bytes));
  std::string_view line;
  std::optional<NamedOrder> order;
  std::size_t columns = 0;
  std::vector<std::string_view> cells;
  std::uint64_t rows = 0;
  while (lines.Next(line)) {
    if (Trim(line).empty()) continue;
    SplitFields(line, GuessSeparator(line), cells);
    if (!IsRow(cells)) {
      if (rows > 0 && line.front() != '#' && builder.SkipRow()) {
        builder.Warn({RemarkCode::kLineIsNoneButThis,
                      {{"line", lines.line_number()},
                       {"form", "image,latitude,longitude,height"},
                       {"text", Quoted(Trim(line), 80)}}});
      }
      continue;
    }
    if (rows == 0) {
      columns = cells.size();
      order = OrderOfLetters(cells[1], cells[2]);
    }
    const auto number = [&](std::size_t i) {
      return i < cells.size() ? ReadBareNumber(cells[i]) : std::nullopt;
    };
    const double first = *ParseListCoordinate(cells[1]), second = *ParseListCoordinate(cells[2]);
    CameraEvent event = EventByName(rows, cells[0]);
    event.written = PlaceOfCells(first, second, order);
    if (IsInDegrees(first, second)) event.position = geo::LatLon{event.written->y, event.written->x};
    event.height_ellipsoid_m = number(3);
    if (const std::size_t accuracy_at = AccuracyColumn(columns); accuracy_at > 0) {
      const auto horizontal = number(accuracy_at);
      event.sigma_in_ned_m = PositiveSigmas(horizontal, horizontal, number(accuracy_at + 1));
    }
    ++rows;
    builder.Add(std::move(event));
  }
  if (rows == 0) return builder.Refuse(RemarkCode::kFileNamesNoPlace);
  builder.Count("row", rows);
  if (columns >= 7) builder.Warn(RemarkCode::kAnglesWithoutHeader);
  builder.log().written_order_is_named = order.has_value();
  builder.log().mapping = {"height -> above the ellipsoid", "no angles"};
  return std::move(builder).Finish();
}

}  // namespace skyquilt::flight
