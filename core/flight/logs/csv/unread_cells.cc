#include "core/flight/logs/csv/unread_cells.h"

#include <algorithm>
#include <utility>

#include "core/flight/bytes/text_fields.h"

namespace skyquilt::flight {
namespace {

constexpr std::size_t kCellsNamed = 3;

constexpr std::pair<CsvMeaning, std::string_view> kForms[] = {
    {CsvMeaning::kLat, "46.8426, 46,8426, N46.8426, -46.8426, 46°50'33.4\" N or 46 50 33.4 N"},
    {CsvMeaning::kLon, "91.9945, 91,9945, W91.9945, -91.9945, 91°59'40.4\" W or 91 59 40.4 W"},
    {CsvMeaning::kUtc,
     "2016-06-23T21:31:09Z, 2016-06-23 21:31:09, 23.06.2016 21:31:09 or 6/23/2016 9:31:09 PM"},
    {CsvMeaning::kDate, "2016-06-23, 23.06.2016 or 6/23/2016"},
    {CsvMeaning::kTimeOfDay, "21:31:09 or 9:31:09 PM"},
    {CsvMeaning::kLatLetter, "N or S"},
    {CsvMeaning::kLonLetter, "E or W"},
    {CsvMeaning::kTime, "12.5, 12,5, 0:00:12.5 or 12.5s"},
};

std::string_view FormsRead(CsvMeaning meaning) {
  for (const auto& [of, forms] : kForms) {
    if (of == meaning) return forms;
  }
  return "1234.5, 1234,5 or 1,234.5, with a unit of its kind behind it or in the column's name";
}

}  // namespace

bool IsEmptyCell(std::string_view cell) {
  constexpr std::size_t kLongest = 5;
  if (cell.size() > kLongest) return false;
  return IsOneOf(LowerCase(cell), {"", "-", "--", "n/a", "#n/a", "na", "none", "null", "nan", "nil", "?"});
}

void UnreadCells::Count(std::size_t column, bool is_read, std::size_t line, std::string_view cell) {
  if (column >= columns_.size()) columns_.resize(column + 1);
  Column& cells = columns_[column];
  if (is_read) {
    ++cells.read;
    return;
  }
  if (++cells.unread <= kCellsNamed) cells.first.push_back({line, Quoted(cell)});
}

Remark UnreadCells::NothingRead(const CsvColumn& column, const Column& cells) const {
  return {RemarkCode::kCellsUnread,
          {{"cells", cells.unread},
           {"column", Quoted(column.header)},
           {"meaning_words", std::string(CsvMeaningName(column.meaning))},
           {"line", cells.first.front().line},
           {"cell", cells.first.front().text},
           {"forms_words", std::string(FormsRead(column.meaning))}}};
}

void UnreadCells::Tell(const std::vector<CsvColumn>& columns, LogBuilder& builder) const {
  for (std::size_t i = 0; i < std::min(columns.size(), columns_.size()); ++i) {
    const Column& cells = columns_[i];
    if (cells.unread == 0) continue;
    if (cells.read == 0 && cells.unread > 1) {
      builder.Warn(NothingRead(columns[i], cells));
      continue;
    }
    for (const Cell& cell : cells.first) {
      builder.Warn({RemarkCode::kCellUnread,
                    {{"line", cell.line},
                     {"column", Quoted(columns[i].header)},
                     {"cell", cell.text},
                     {"meaning_words", std::string(CsvMeaningName(columns[i].meaning))}}});
    }
    if (cells.unread > cells.first.size()) {
      builder.Warn({RemarkCode::kMoreCellsUnread,
                    {{"cells", cells.unread - cells.first.size()}, {"column", Quoted(columns[i].header)}}});
    }
  }
}

std::optional<Remark> UnreadCells::WhyNothing(const std::vector<CsvColumn>& columns, CsvMeaning first,
                                              CsvMeaning last) const {
  for (std::size_t i = 0; i < std::min(columns.size(), columns_.size()); ++i) {
    const bool is_meant = columns[i].meaning >= first && columns[i].meaning <= last;
    if (is_meant && columns_[i].read == 0 && columns_[i].unread > 0)
      return NothingRead(columns[i], columns_[i]);
  }
  return std::nullopt;
}

}  // namespace skyquilt::flight
