#include "core/flight/logs/texts/list_rows.h"

#include <algorithm>
#include <cctype>
#include <iterator>
#include <string>
#include <utility>

#include "core/base/text/file_names.h"
#include "core/flight/logs/coordinate_cell.h"
#include "core/flight/logs/csv/csv_columns.h"
#include "core/flight/logs/csv/csv_meanings.h"
#include "core/flight/logs/system_line.h"

namespace skyquilt::flight {
namespace {

using M = CsvMeaning;
constexpr int kLinesAboveRows = 24;  // a system, names of columns, comments
constexpr std::size_t kLongestColumnName = 64;
constexpr std::size_t kLongestLineOfNames = 16'384;

std::string LettersOfColumn(std::string_view name) {
  std::string letters;
  for (const char c : LowerCase(name.substr(0, kLongestColumnName))) {
    if (c >= 'a' && c <= 'z') letters += c;
  }
  return letters;
}

// As tables name their columns, and as lists do: kEast or kNorth, also of degrees, where the name says which
// of a pair it is; nothing for a name that none of them has.
std::optional<M> MeaningOfColumn(std::string_view name) {
  name = name.substr(0, kLongestColumnName);
  const M meaning = MapTolerantColumns({name}).front().meaning;
  if (meaning == M::kLon) return M::kEast;
  if (meaning == M::kLat) return M::kNorth;
  for (const auto& [first, last] : {std::pair{M::kHeightEllipsoid, M::kHeightAboveGround},
                                    {M::kSigmaHorizontal, M::kSigmaVertical},
                                    {M::kRoll, M::kYaw},
                                    {M::kImage, M::kImage}}) {
    if (meaning >= first && meaning <= last) return meaning;
  }
  const std::string letters = LettersOfColumn(name);
  if (letters.size() == 1 && Trim(name).size() > 1) return std::nullopt;  // the "n" of "32N"
  if (const ListName* known = FindListName(letters))
    return known->order == PairOrder::kNamed ? known->meaning : M::kIgnored;
  if (letters.starts_with("longitude")) return M::kEast;
  if (letters.starts_with("latitude")) return M::kNorth;
  return std::nullopt;
}

bool IsKnownColumn(std::string_view name) { return MeaningOfColumn(name).has_value(); }

constexpr char kQuote = '"';

enum class NameBegins { kBehindNumber, kWithRow };

// A photo's name that blanks have cut is one cell again: up to its ending, from the quote that opens it or
// else from behind the last number ("20 DJI 0001.JPG", "\"IMG 1 (2).jpg\""), or from where the row begins.
// Whether that made one of several words without quotes.
bool JoinPictureName(NameBegins begins, std::vector<std::string_view>& words) {
  const auto last = std::find_if(words.begin(), words.end(), [](std::string_view word) {
    if (word.ends_with(kQuote)) word.remove_suffix(1);
    return IsNamedAsPicture(word);
  });
  if (last == words.end()) return false;
  const bool is_quoted = last->ends_with(kQuote);
  auto first = last;
  if (is_quoted) {
    while (first != words.begin() && !first->starts_with(kQuote)) --first;
  } else if (begins == NameBegins::kWithRow) {
    first = words.begin();
  } else {
    while (first != words.begin() && !ReadBareNumber(*std::prev(first))) --first;
  }
  const bool is_joined = !is_quoted && first != last;
  const auto length = static_cast<std::size_t>(last->data() + last->size() - first->data());
  *first = Unquote({first->data(), length});
  words.erase(std::next(first), std::next(last));
  return is_joined;
}

enum class RowCut { kNone, kAsWritten, kNameJoined };

RowCut CutRow(std::string_view line, const IsListRow& is_row, std::vector<std::string_view>& cells) {
  for (const char separator : {'\t', ';', ','}) {
    if (line.find(separator) == std::string_view::npos) continue;
    SplitFields(line, separator, cells);
    const bool has_gaps =
        std::any_of(cells.begin(), cells.end(), [](std::string_view c) { return c.empty(); });
    if (separator == '\t' && has_gaps) continue;  // they only align columns
    if (is_row(cells)) return RowCut::kAsWritten;
  }
  SplitBlanks(line, cells);
  const auto joined = [&](NameBegins begins) {
    std::vector<std::string_view> named = cells;
    const bool is_joined = JoinPictureName(begins, named);
    if (!is_row(named)) return RowCut::kNone;
    cells = std::move(named);
    return is_joined ? RowCut::kNameJoined : RowCut::kAsWritten;
  };
  if (const RowCut cut = joined(NameBegins::kBehindNumber); cut != RowCut::kNone) return cut;
  return is_row(cells) ? RowCut::kAsWritten : joined(NameBegins::kWithRow);
}

}  // namespace

std::vector<std::string_view> ColumnNames(std::string_view line) {
  std::vector<std::string_view> words;
  const std::size_t begin = line.find_first_not_of("# \t");
  if (begin == std::string_view::npos || line.size() > kLongestLineOfNames) return {};
  line = line.substr(begin);
  const bool is_cut = line.find_first_of(",;\t") != std::string_view::npos;
  if (is_cut) {
    SplitFields(line, GuessSeparator(line), words);
  } else {
    SplitBlanks(line, words);
  }
  const bool has_number =
      std::any_of(words.begin(), words.end(), [](std::string_view w) { return ParseNumber(w).has_value(); });
  if (has_number || std::count_if(words.begin(), words.end(), IsKnownColumn) < 2) words.clear();
  return words;
}

std::optional<double> ParseListCoordinate(std::string_view cell) {
  if (const auto number = ReadBareNumber(cell)) return number;
  const auto coordinate = ReadCoordinateCell(cell);
  return coordinate ? std::optional<double>(coordinate->value) : std::nullopt;
}

bool LooksLikeImageName(std::string_view word) {
  const std::size_t dot = word.rfind('.');
  if (dot == std::string_view::npos || word.size() - dot < 3 || word.size() - dot > 6) return false;
  const std::string_view ending = word.substr(dot + 1);
  const auto is_letter = [](unsigned char c) { return std::isalpha(c) != 0; };
  const auto is_letter_or_digit = [](unsigned char c) { return std::isalnum(c) != 0; };
  return std::any_of(ending.begin(), ending.end(), is_letter) &&
         std::all_of(ending.begin(), ending.end(), is_letter_or_digit) && !ReadBareNumber(word);
}

bool SplitListRow(std::string_view line, const IsListRow& is_row, std::vector<std::string_view>& cells) {
  return CutRow(line, is_row, cells) != RowCut::kNone;
}

std::optional<ListTop> ReadListTop(std::string_view text, const IsListRow& is_row) {
  ListTop top;
  SystemLine system;
  LineReader lines(text);
  std::string_view line;
  for (int i = 0; i < kLinesAboveRows && lines.Next(line); ++i) {
    if (Trim(line).empty()) continue;
    const bool is_comment = line.front() == '#';
    const RowCut cut = is_comment ? RowCut::kNone : CutRow(line, is_row, top.row);
    if (cut != RowCut::kNone) {
      top.name_is_joined = cut == RowCut::kNameJoined;
      top.row_line = line;
      top.row_number = lines.line_number();
      top.row_offset = lines.offset();
      return top;
    }
    std::vector<std::string_view> columns = ColumnNames(line);
    if (!columns.empty() && top.columns.empty()) {
      top.columns = std::move(columns);
      continue;
    }
    const std::size_t number = lines.line_number();
    if (TakeSystem(SystemOfLine(line, lines), system)) {
      top.system = system.text;
    } else if (!is_comment) {
      top.skipped_lines.push_back(number);
    }
  }
  return std::nullopt;
}

std::optional<NamedOrder> OrderOfColumns(const std::vector<std::string_view>& columns) {
  std::optional<std::size_t> east, north;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const std::optional<M> meaning = MeaningOfColumn(columns[i]);
    if (!east && meaning == M::kEast) east = i;
    if (!north && meaning == M::kNorth) north = i;
  }
  if (!east || !north) return std::nullopt;
  return *east < *north ? NamedOrder::kEastFirst : NamedOrder::kNorthFirst;
}

bool AreNamesOfColumns(const std::vector<std::string_view>& columns) {
  const auto known = std::count_if(columns.begin(), columns.end(), IsKnownColumn);
  constexpr std::ptrdiff_t kOfAList = 3;  // a photo and two coordinates
  return known >= kOfAList || (known > 0 && 2 * known >= static_cast<std::ptrdiff_t>(columns.size()));
}

std::optional<NamedOrder> OrderOfLetters(std::string_view first, std::string_view second) {
  const auto has_one_of = [](std::string_view cell, std::string_view letters) {
    const auto read = ReadCoordinateCell(cell);
    return read && read->hemisphere != 0 && letters.find(read->hemisphere) != std::string_view::npos;
  };
  if (has_one_of(first, "NS") || has_one_of(second, "EW")) return NamedOrder::kNorthFirst;
  if (has_one_of(first, "EW") || has_one_of(second, "NS")) return NamedOrder::kEastFirst;
  return std::nullopt;
}

}  // namespace skyquilt::flight
