#include "core/flight/logs/csv/list_columns.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>

#include "core/base/text/file_names.h"
#include "core/flight/logs/csv/csv_rows.h"

namespace skyquilt::flight {
namespace {

using M = CsvMeaning;
constexpr std::size_t kLongestName = 64;

std::string LettersOf(std::string_view text) {
  return LettersAndDigits(LowerCase(text.substr(0, kLongestName)));
}

// A column's name, and its unit in brackets: "omega_rad" and "omega [rad]" as "omega", "(rad)".
struct NameAndUnit {
  std::string letters;
  std::string unit;
};

NameAndUnit WithUnitInBrackets(std::string_view header) {
  const std::size_t bracket = std::min(header.find_first_of("(["), header.size());
  return {LettersOf(header.substr(0, bracket)), std::string(header.substr(bracket))};
}

// Also what a height counts from: "z_m", "h_ell [m]" and "H-Ell (m)" as "h", "(ell)(m)".
NameAndUnit WithUnitBehind(std::string_view header) {
  const std::size_t bracket = std::min(header.find_first_of("(["), header.size());
  const std::string_view base = Trim(header.substr(0, bracket));
  const std::size_t cut = base.find_last_of("_ -");
  if (cut == std::string_view::npos || header.size() > kLongestName) return {};
  const std::string unit = LowerCase(base.substr(cut + 1));
  if (FindUnit(unit, Dimension::kLength) == nullptr && FindUnit(unit, Dimension::kAngle) == nullptr &&
      !IsZeroOfHeights(LettersAndDigits(unit)))
    return {};
  return {LettersOf(base.substr(0, cut)), "(" + unit + ")" + std::string(header.substr(bracket))};
}

// As the column of a log that has the same kind of unit.
CsvColumn MapAs(std::string_view name, const std::string& unit, const CsvColumn& column) {
  const std::string whole = std::string(name) + unit;
  CsvColumn mapped = MapTolerantColumns({std::string_view(whole)}).front();
  mapped.header = column.header;
  return mapped;
}

// "altitude above something": a height, whatever it counts from.
void MapUnknownHeight(const NameAndUnit& name, CsvColumn& column) {
  if (!StartsWithOneOf(name.letters, {"alt", "elev", "height", "hoehe", "hhe"})) return;
  column.meant = M::kHeightAmsl;
  column.unknown_words = column.header;
}

bool MapByNamesOfLists(const NameAndUnit& name, CsvColumn& column) {
  const ListName* known = FindListName(name.letters);
  if (known == nullptr || known->meaning == M::kIgnored) return false;
  if (known->meaning == M::kEast || known->meaning == M::kNorth) {
    column.meaning = known->meaning;  // in the unit of the system, whatever the name says
    return true;
  }
  const bool is_open_height = known->meaning == M::kHeightAboveTakeoff;
  const bool is_height = is_open_height || known->meaning == M::kHeightAmsl;
  column = MapAs(is_open_height ? "height" : is_height ? "altitude" : "roll", name.unit, column);
  M& meaning = column.meaning == M::kIgnored ? column.meant : column.meaning;
  if (!is_height) meaning = known->meaning;
  return true;
}

// "Accuracy_X/Y/Z_(m)", "acc", "sigma h", "stdH", "VRMS", "lat_std": of angles they are not read.
void MapAccuracy(const NameAndUnit& name, bool has_horizontal, CsvColumn& column) {
  std::string_view of = name.letters;
  constexpr std::array<std::string_view, 9> kWords = {"accuracy", "acc", "sigma", "stddev",   "stdev",
                                                      "std",      "sd",  "rms",   "precision"};
  constexpr std::ptrdiff_t kPlainWords = 3;  // alone the others may be of anything
  auto word =
      std::find_if(kWords.begin(), kWords.end(), [&](std::string_view w) { return of.starts_with(w); });
  if (word != kWords.end()) {
    of.remove_prefix(word->size());
  } else {
    word = std::find_if(kWords.begin(), kWords.end(), [&](std::string_view w) { return of.ends_with(w); });
    if (word == kWords.end()) return;
    of.remove_suffix(word->size());
  }
  constexpr std::array<std::string_view, 15> kHorizontal = {
      "h",   "hor", "horz", "horiz",    "horizontal", "x",    "y",    "xy",
      "xyz", "lat", "lon",  "latitude", "longitude",  "east", "north"};
  constexpr std::array<std::string_view, 7> kVertical = {"v",        "vert", "vertical", "z",
                                                         "altitude", "alt",  "height"};
  const bool is_plain = word - kWords.begin() < kPlainWords;
  const bool is_open = is_plain && (of.empty() || of == "m" || of == "position");
  if (IsOneOf(of, kVertical) || (is_open && has_horizontal)) {
    column = MapAs("accuracy vertical", name.unit, column);
  } else if (IsOneOf(of, kHorizontal) || is_open) {
    column = MapAs("accuracy horizontal", name.unit, column);
  }
}

// Beside angles px and py are a lens's middle, as RealityCapture writes it.
bool NamesMarks(const std::vector<CsvColumn>& columns, MarkPart part) {
  const bool has_angles = HasColumn(columns, M::kPitch) || HasColumn(columns, M::kPhi);
  return !has_angles && std::any_of(columns.begin(), columns.end(), [&](const CsvColumn& column) {
    const ListName* known = FindListName(LettersOf(column.header));
    return known != nullptr && known->mark == part;
  });
}

// Tables of marks that points have in photos: their coordinates are not the photos'. Beside degrees, which
// stand in tables of all kinds, only pixels tell.
bool HasPoints(const std::vector<CsvColumn>& columns) {
  return HasPixels(columns) || (HasPlane(columns) && NamesMarks(columns, MarkPart::kPoint));
}

bool IsListOfPhotos(const std::vector<CsvColumn>& columns) {
  return NamesPhotos(columns) && (HasDegrees(columns) || HasPlane(columns)) && !HasPoints(columns);
}

// The image, and the two coordinates, are what their columns say.
bool IsRowOf(const std::vector<CsvColumn>& columns, const std::vector<std::string_view>& cells) {
  bool has_image = false;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const M meaning = columns[i].meaning;
    const bool is_coordinate =
        meaning == M::kLat || meaning == M::kLon || meaning == M::kEast || meaning == M::kNorth;
    if (is_coordinate && (i >= cells.size() || !ReadCsvNumber(columns[i], cells[i]))) return false;
    has_image = has_image || ((meaning == M::kImage || meaning == M::kIsPhoto) && i < cells.size() &&
                              !cells[i].empty() && !ReadBareNumber(cells[i]));
  }
  return has_image;
}

// Empty where there is none.
std::string_view FirstRow(LineReader below) {
  std::string_view line;
  do {
    if (!below.Next(line)) return {};
  } while (IsBlankOrComment(line));
  return line;
}

// Rows may be cut otherwise than the line above them: the first one tells. Nothing where none fits.
std::optional<char> SeparatorOfRows(const ListHeading& heading, std::string_view row) {
  std::vector<std::string_view> cells;
  for (const char separator : {heading.separator, '\t', ';', ',', '|', ' '}) {
    SplitFields(row, separator, cells);
    if (IsRowOf(heading.columns, cells)) return separator;
  }
  return std::nullopt;
}

// Whatever their column is called ("id", "camera"): files of pictures below it are the photos. Rows may be
// cut otherwise than the names: then the first cell alone tells. Metashape's "PhotoID" are without endings.
void TakePicturesBelow(std::string_view row, char separator, std::vector<CsvColumn>& columns) {
  if (NamesPhotos(columns) || columns.empty()) return;
  std::vector<std::string_view> cells;
  SplitFields(row, separator, cells);
  for (std::size_t i = 0; i < std::min(columns.size(), cells.size()); ++i) {
    if (columns[i].meaning != M::kIgnored || !IsNamedAsPicture(cells[i])) continue;
    columns[i].meaning = M::kImage;
    return;
  }
  if (columns.front().meaning != M::kIgnored) return;
  row.remove_prefix(std::min(row.find_first_not_of("\" \t"), row.size()));
  const std::string_view cell = row.substr(0, row.find_first_of("\" \t;,|"));
  const bool is_called_photo = LettersOf(columns.front().header) == "photoid";
  if (IsNamedAsPicture(cell) || (is_called_photo && !cell.empty() && !ReadBareNumber(cell)))
    columns.front().meaning = M::kImage;
}

// Cut at blanks, but "yaw (decimal degrees)" is one name.
void SplitNames(std::string_view line, std::vector<std::string_view>& names) {
  std::vector<std::string_view> words;
  SplitBlanks(line, words);
  names.clear();
  bool is_open = false;
  for (const std::string_view word : words) {
    const bool goes_on = !names.empty() && (is_open || word.front() == '(' || word.front() == '[');
    if (goes_on) {
      const char* const begin = names.back().data();
      names.back() = {begin, static_cast<std::size_t>(word.data() + word.size() - begin)};
    } else {
      names.push_back(word);
    }
    const std::size_t bracket = word.find_last_of("()[]");
    if (bracket != std::string_view::npos) is_open = word[bracket] == '(' || word[bracket] == '[';
  }
}

// Without the # and "columns:" before the names.
std::string_view NamesIn(std::string_view line) {
  if (!line.starts_with('#')) return line;
  line = line.substr(std::min(line.find_first_not_of("# \t"), line.size()));
  const std::size_t word_end = line.find_first_of(" \t,;|");
  const bool is_label = word_end != std::string_view::npos && word_end > 0 && line[word_end - 1] == ':';
  return is_label ? Trim(line.substr(word_end)) : line;
}

}  // namespace

std::vector<CsvColumn> MapListColumns(const std::vector<std::string_view>& header) {
  std::vector<CsvColumn> columns = MapTolerantColumns(header);
  const bool has_degrees = HasDegrees(columns);
  const std::vector<CsvColumn> of_logs = columns;
  for (CsvColumn& column : columns) {
    if (column.meaning != M::kIgnored || column.meant != M::kIgnored) continue;
    const std::string name = column.header;  // the column is made anew
    if (MapByNamesOfLists(WithUnitInBrackets(name), column) ||
        MapByNamesOfLists(WithUnitBehind(name), column))
      continue;
    MapAccuracy(WithUnitInBrackets(name), HasColumn(columns, M::kSigmaHorizontal), column);
    if (column.meaning == M::kIgnored && column.meant == M::kIgnored)
      MapUnknownHeight(WithUnitInBrackets(name), column);
  }
  // One coordinate alone, or beside degrees, is none.
  if (HasPlane(columns) && !has_degrees) return columns;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (columns[i].meaning == M::kEast || columns[i].meaning == M::kNorth) columns[i] = of_logs[i];
  }
  return columns;
}

PairOrder OrderOfPair(const std::vector<CsvColumn>& columns) {
  PairOrder order = PairOrder::kNamed;
  for (const M meaning : {M::kEast, M::kNorth}) {
    const CsvColumn* column = ColumnOf(columns, meaning);
    if (column == nullptr) return PairOrder::kNamed;
    const ListName* name = FindListName(WithUnitInBrackets(column->header).letters);
    if (name == nullptr) name = FindListName(WithUnitBehind(column->header).letters);
    if (name == nullptr || name->order == PairOrder::kNamed) return PairOrder::kNamed;
    order = name->order;
  }
  return order;
}

bool HasDegrees(const std::vector<CsvColumn>& columns) {
  return HasColumn(columns, M::kLat) && HasColumn(columns, M::kLon);
}

bool HasPlane(const std::vector<CsvColumn>& columns) {
  return HasColumn(columns, M::kEast) && HasColumn(columns, M::kNorth);
}

bool NamesPhotos(const std::vector<CsvColumn>& columns) {
  return HasColumn(columns, M::kImage) || HasColumn(columns, M::kIsPhoto);
}

bool HasPixels(const std::vector<CsvColumn>& columns) { return NamesMarks(columns, MarkPart::kPixel); }

std::optional<ListHeading> ReadListHeading(std::string_view line, LineReader below) {
  const std::string_view names = NamesIn(line);
  ListHeading heading;
  heading.separator = GuessSeparator(names);
  std::vector<std::string_view> cells;
  SplitFields(names, heading.separator, cells);
  const bool is_cut_at_blanks = cells.size() == 1;
  if (is_cut_at_blanks) {
    heading.separator = ' ';
    SplitNames(names, cells);
  }
  heading.columns = MapListColumns(cells);
  const std::string_view row = FirstRow(below);
  TakePicturesBelow(row, heading.separator, heading.columns);
  if (!IsListOfPhotos(heading.columns)) return std::nullopt;
  if (const auto separator = SeparatorOfRows(heading, row)) {
    heading.separator = *separator;
    heading.fits_row = true;
  } else if (is_cut_at_blanks && HasColumn(heading.columns, M::kIgnored)) {
    return std::nullopt;
  }
  return heading;
}

}  // namespace skyquilt::flight
