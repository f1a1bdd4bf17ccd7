#include "core/flight/logs/csv/csv_columns.h"

#include <fmt/format.h>

#include <array>
#include <initializer_list>
#include <optional>
#include <utility>

#include "core/flight/bytes/text_fields.h"
#include "core/flight/logs/csv/csv_units.h"

namespace skyquilt::flight {
namespace {

using M = CsvMeaning;

// "acc_x [m/s^2]" -> "acc_x ", "m/s^2"; "altitude (amsl) [ft]" -> "altitude  ", "amsl ft".
std::pair<std::string, std::string> CutBrackets(const std::string& lower) {
  std::string base, inside;
  std::size_t at = 0;
  while (at < lower.size()) {
    const std::size_t open = std::min(lower.find_first_of("([", at), lower.size());
    base += lower.substr(at, open - at);
    if (open == lower.size()) break;
    const std::size_t close = std::min(lower.find_first_of(")]", open), lower.size());
    const std::string_view words = Trim(std::string_view(lower).substr(open + 1, close - open - 1));
    if (!inside.empty() && !words.empty()) inside += ' ';
    inside += words;
    at = close + 1;
  }
  return {base, inside};
}

constexpr std::size_t kMaxColumnName = 64;  // every cut of a name is tried

struct MeaningAndUnit {
  M meaning = M::kIgnored;  // not said
  std::string unit;
};

// What a height counts from by a word beside it; levels of nations are sea levels, to their decimetres.
M ZeroOfHeights(std::string_view word) {
  constexpr std::array<std::string_view, 36> kSea = {
      "amsl",     "msl",      "asl",      "sea",      "orthometric", "egm84",  "egm96",  "egm08", "egm2008",
      "nn",       "nhn",      "dhhn92",   "dhhn2016", "dhhn12",      "navd88", "ngvd29", "navd",  "nap",
      "evrf",     "evrf2000", "evrf2007", "evrf2019", "ngf",         "ign69",  "odn",    "ahd",   "cgvd28",
      "cgvd2013", "ln02",     "lhn95",    "rh2000",   "nn2000",      "n2000",  "dvr90",  "taw",   "nzvd2016"};
  constexpr std::array<std::string_view, 7> kEllipsoid = {"hae",   "ellipsoidal", "ellipsoid", "ellipsoidic",
                                                          "wgs84", "ell",         "grs80"};
  if (IsOneOf(word, kSea)) return M::kHeightAmsl;
  if (IsOneOf(word, kEllipsoid)) return M::kHeightEllipsoid;
  return word == "agl" ? M::kHeightAboveGround : M::kIgnored;
}

// Words beside the unit that say above what a height counts: "ft amsl", "m, ellipsoidal", "wgs84", "m
// navd88", "m ü. nhn", "m ü. m."; nothing where one of them is not known, or they contradict each other.
std::optional<MeaningAndUnit> ReadHeightWords(std::string words) {
  constexpr std::array<std::string_view, 6> kBetween = {"above", "mean", "level", "height", "the", "of"};
  constexpr std::array<std::string_view, 5> kOver = {"", "u", "ber", "ueber", "over"};  // "ü." has no letter
  std::replace_if(
      words.begin(), words.end(), [](char c) { return c == ',' || c == ';' || c == '_'; }, ' ');
  std::vector<std::string_view> parts;
  SplitBlanks(words, parts);
  MeaningAndUnit read;
  bool is_over = false;
  for (const std::string_view part : parts) {
    const std::string word = LettersAndDigits(part);
    M said = ZeroOfHeights(word);
    if (is_over && (word == "m" || word == "meer")) said = M::kHeightAmsl;  // "über Meer"
    const bool was_over = std::exchange(is_over, IsOneOf(word, kOver));
    if (is_over || (said == M::kIgnored && (IsOneOf(word, kBetween) || (was_over && word == "dem"))))
      continue;
    if (said == M::kIgnored) {
      read.unit += (read.unit.empty() ? "" : " ") + word;
    } else if (read.meaning != M::kIgnored && read.meaning != said) {
      return std::nullopt;
    } else {
      read.meaning = said;
    }
  }
  if (!read.unit.empty() && FindUnit(read.unit, Dimension::kLength) == nullptr) return std::nullopt;
  return read;
}

// "lonDeg" and "TimeUS" as "lon_deg" and "time_us": a capital behind a small letter or a digit begins a word.
std::string WordsOf(std::string_view header) {
  std::string words;
  for (std::size_t i = 0; i < header.size(); ++i) {
    const auto is_capital = [&](std::size_t k) { return header[k] >= 'A' && header[k] <= 'Z'; };
    const auto is_letter = [&](std::size_t k) {
      return is_capital(k) || (header[k] >= 'a' && header[k] <= 'z');
    };
    if (i > 0 && is_capital(i) && is_letter(i - 1) && !is_capital(i - 1)) words += '_';
    words += header[i];
  }
  return LowerCase(words);
}

// The last words may be the unit: "gyro_x_dps", "lat_deg", "vel_n_m_s"; in names of one word, the last
// letters: "LATDEG", "timeus".
MeaningAndUnit CutUnit(const std::string& words) {
  if (words.size() > kMaxColumnName) return {};
  std::string unit;
  std::size_t end = words.size();
  for (int parts = 0; parts < 2; ++parts) {
    const std::size_t cut = end == 0 ? std::string::npos : words.find_last_of("_ .", end - 1);
    if (cut == std::string::npos) break;
    const std::string word = words.substr(cut + 1, end - cut - 1);
    unit = unit.empty() ? word : word + "/" + unit;
    end = cut;
    const M meaning = FindCsvSynonym(LettersAndDigits(words.substr(0, cut)));
    if (meaning != M::kIgnored && FindUnit(unit, CsvMeaningDimension(meaning)) != nullptr)
      return {meaning, unit};
  }
  constexpr std::size_t kMinName = 3;  // "ts" and "ms" are no "t" in seconds
  const std::string letters = LettersAndDigits(words);
  for (std::size_t length = kMinName; length < letters.size(); ++length) {
    const M meaning = FindCsvSynonym(letters.substr(0, length));
    const std::string rest = letters.substr(length);
    if (meaning != M::kIgnored && FindUnit(rest, CsvMeaningDimension(meaning)) != nullptr)
      return {meaning, rest};
  }
  return {};
}

// "height_navd88", "elevation  _egm96", "höhe über nhn": a height whose last words say its zero or unit.
MeaningAndUnit CutHeightWords(std::string base) {
  constexpr std::array<std::string_view, 6> kAbove = {"", "u", "ber", "ueber", "over", "above"};
  if (base.size() > kMaxColumnName) return {};
  std::replace_if(
      base.begin(), base.end(), [](char c) { return c == '_' || c == '.' || c == '-'; }, ' ');
  std::vector<std::string_view> parts;
  SplitBlanks(base, parts);
  std::string behind;
  for (std::size_t count = parts.size(); count > 1; --count) {
    const std::string_view last = parts[count - 1];
    if (ZeroOfHeights(last) == M::kIgnored && FindUnit(last, Dimension::kLength) == nullptr) break;
    behind = std::string(last) + (behind.empty() ? "" : " ") + behind;
    std::string name;
    for (std::size_t i = 0; i + 1 < count; ++i) {
      const std::string word = LettersAndDigits(parts[i]);
      if (!IsOneOf(word, kAbove)) name += word;
    }
    if (const M meaning = FindCsvSynonym(name); IsHeight(meaning)) return {meaning, behind};
  }
  return {};
}

// The name of a height that does not say above what: "altitude", "alt_m", "Z/Altitude".
bool IsBareHeight(const std::string& letters) {
  return StartsWithOneOf(letters, {"alt", "zalt", "elev", "hhe", "hoehe", "cota"}) &&
         !HoldsOneOf(letters, {"msl", "sea", "nn"});
}

// "deg, wgs 84", "deg min sec", "n/s": the cells are degrees. Not "w": which sign is that?
bool SaysDegrees(std::string words) {
  constexpr std::array<std::string_view, 11> kBeside = {"wgs", "84",      "min",     "sec", "dms",  "n/s",
                                                        "e/w", "minutes", "seconds", "n",   "north"};
  std::replace(words.begin(), words.end(), ',', ' ');
  std::vector<std::string_view> parts;
  SplitBlanks(words, parts);
  return std::all_of(parts.begin(), parts.end(), [&](std::string_view word) {
    const CsvUnit* unit = FindUnit(word, Dimension::kCoordinate);
    return unit != nullptr ? unit->factor == 1.0 : IsOneOf(word, kBeside);
  });
}

// "Time (UTC)", "timestamp [local]", "time (hh:mm:ss)": the cells say how they count.
bool SaysClock(std::string_view words) {
  return HoldsOneOf(words, {"utc", "gmt", "gpst", "local", "iso", "hh:mm"});
}

// "Time (UTC)" and "UTC+0", but not "Time (UTC+2)", "UTC + 2" and "UTC time (UTC+2)": that is a local clock,
// whose zone the photos tell.
bool SaysUtc(std::string_view lower) {
  bool says_utc = false;
  for (const std::string_view word : {"utc", "gmt"}) {
    for (std::size_t at = lower.find(word); at != std::string_view::npos; at = lower.find(word, at + 1)) {
      const std::string_view behind = Trim(lower.substr(at + word.size()));
      const std::size_t sign = behind.starts_with('+') ? 1 : LengthOfMinus(behind);
      const std::string_view offset = Trim(behind.substr(sign));
      const std::string_view digits = offset.substr(0, offset.find_first_not_of("0123456789:"));
      if (sign > 0 && digits.find_first_of("123456789") != std::string_view::npos) return false;
      says_utc = true;
    }
  }
  return says_utc;
}

// "Time (GPST)" and "GPSTimestamp (GPST)", but not "GPSTime", as programs call UTC too.
bool SaysGpsScale(std::string_view lower) {
  constexpr std::string_view kScale = "gpst";
  for (std::size_t at = lower.find(kScale); at != std::string_view::npos; at = lower.find(kScale, at + 1)) {
    const std::string_view behind = lower.substr(at + kScale.size());
    if (behind.empty() || behind.front() < 'a' || behind.front() > 'z') return true;
  }
  return false;
}

CsvColumn MapTolerantColumn(std::string_view header) {
  CsvColumn column;
  column.header = Trim(header);
  const std::string lower = LowerCase(column.header);
  auto [base, unit] = CutBrackets(lower);
  column.counts_gps = SaysGpsScale(lower);
  column.says_utc = column.counts_gps || SaysUtc(lower);
  column.meaning = FindCsvSynonym(LettersAndDigits(base));
  if (column.meaning == M::kIgnored && unit.empty()) {
    MeaningAndUnit found = CutUnit(WordsOf(column.header));
    column.meaning = found.meaning;
    unit = std::move(found.unit);
  }
  if (column.meaning == M::kIgnored) {
    const MeaningAndUnit found = CutHeightWords(base);
    column.meaning = found.meaning;
    if (found.meaning != M::kIgnored) unit += (unit.empty() ? "" : " ") + found.unit;
  }
  column.is_bare_height = column.meaning == M::kHeightAmsl && IsBareHeight(LettersAndDigits(base));
  const Dimension dimension = CsvMeaningDimension(column.meaning);
  if (dimension == Dimension::kLength && !unit.empty() && FindUnit(unit, dimension) == nullptr) {
    const auto height = ReadHeightWords(unit);
    if (height && IsHeight(column.meaning)) {
      if (height->meaning != M::kIgnored) {
        column.meaning = height->meaning;
        column.is_bare_height = false;
      }
      unit = height->unit;
    }
  }
  if (FindUnit(unit, dimension) == nullptr && ((dimension == Dimension::kCoordinate && SaysDegrees(unit)) ||
                                               (dimension == Dimension::kTime && SaysClock(unit))))
    unit.clear();
  const auto [scale, name] = DefaultUnit(dimension);
  column.scale = scale;
  column.unit = name;
  if (dimension == Dimension::kNone || unit.empty()) return column;
  if (const CsvUnit* known = FindUnit(unit, dimension)) {
    column.scale = known->factor;
    column.unit = known->name;
    column.unit_is_written = true;
  } else {
    column.meant = std::exchange(column.meaning, M::kIgnored);  // "Time(text)": not a unit of this
    column.unknown_words = unit;
  }
  return column;
}

// What a column's name is without the one of these that it ends with; empty where it ends with none of them.
std::string WithoutEndOf(const CsvColumn& column, std::initializer_list<std::string_view> ends) {
  const std::string letters = LettersAndDigits(LowerCase(column.header.substr(0, kMaxColumnName)));
  for (const std::string_view end : ends) {
    if (letters.size() > end.size() && letters.ends_with(end))
      return letters.substr(0, letters.size() - end.size());
  }
  return {};
}

// Degrees whose minutes stand in a column of their own ("lat_deg", "lat_min") are no coordinate without them:
// whole degrees lie up to a hundred kilometres away. Beside "lat_max" the least is meant.
void LeaveDegreesBesideMinutes(std::vector<CsvColumn>& columns) {
  for (const M coordinate : {M::kLat, M::kLon}) {
    const auto has = [&](std::initializer_list<std::string_view> ends) {
      return std::any_of(columns.begin(), columns.end(), [&](const CsvColumn& column) {
        return FindCsvSynonym(WithoutEndOf(column, ends)) == coordinate;
      });
    };
    if (!has({"minutes", "minute", "mins", "min"}) || has({"maximum", "max"})) continue;
    if (!has({"degrees", "degree", "degs", "deg"})) continue;
    for (CsvColumn& column : columns) {
      const std::string whole = WithoutEndOf(column, {"degrees", "degree", "degs", "deg", "minutes", "minute",
                                                      "mins", "min", "seconds", "second", "secs", "sec"});
      if (column.meaning == coordinate && !whole.empty()) column.meaning = M::kIgnored;
    }
  }
}

}  // namespace

bool IsZeroOfHeights(std::string_view word) { return ZeroOfHeights(word) != M::kIgnored; }

std::string LettersAndDigits(std::string_view lower) {
  std::string letters;
  for (const char c : lower) {
    if ((c >= 'a' && c <= 'z') || IsDigit(c)) letters += c;
  }
  return letters;
}

std::vector<CsvColumn> MapTolerantColumns(const std::vector<std::string_view>& header) {
  std::vector<CsvColumn> columns;
  for (const std::string_view name : header) columns.push_back(MapTolerantColumn(name));
  LeaveDegreesBesideMinutes(columns);
  // Counts of satellites have names that mean something else beside their like alone.
  constexpr std::array kCounts = {std::pair{std::string_view("ns"), M::kLonLetter},
                                  std::pair{std::string_view("sv"), M::kSigmaHorizontal}};
  for (const auto& [name, like] : kCounts) {
    if (HasColumn(columns, like)) continue;
    for (CsvColumn& column : columns) {
      if (LowerCase(column.header) == name) column.meaning = M::kIgnored;
    }
  }
  if (!HasColumn(columns, M::kLat) || !HasColumn(columns, M::kLon)) return columns;
  // Beside a latitude and a longitude it is a height; by itself it may be an axis of anything.
  for (CsvColumn& column : columns) {
    if (column.meaning != M::kIgnored || LowerCase(column.header) != "z") continue;
    column = MapTolerantColumn("altitude");
    column.header = "z";
  }
  return columns;
}

std::vector<Remark> SayUnknownWords(const std::vector<CsvColumn>& columns) {
  std::vector<Remark> said;
  for (const CsvColumn& column : columns) {
    const Dimension dimension = CsvMeaningDimension(column.meant);
    if (dimension != Dimension::kLength && dimension != Dimension::kAngle) continue;
    // Another column says it.
    const auto is_said = [&](const CsvColumn& other) {
      return other.meaning == column.meant || (IsHeight(other.meaning) && IsHeight(column.meant));
    };
    if (std::any_of(columns.begin(), columns.end(), is_said)) continue;
    said.push_back({RemarkCode::kColumnWordsUnknown,
                    {{"column", Quoted(column.header)}, {"word", Quoted(column.unknown_words)}}});
  }
  return said;
}

std::vector<std::string> DescribeColumns(const std::vector<CsvColumn>& columns) {
  std::vector<std::string> lines;
  for (const CsvColumn& column : columns) {
    if (column.meaning == M::kIgnored) continue;
    std::string line = fmt::format("{} -> {}", column.header.substr(0, 80), CsvMeaningName(column.meaning));
    if (!column.unit.empty()) line += fmt::format(", {}", column.unit);
    if (!column.unit.empty() && !column.unit_is_written) line += " (assumed)";
    lines.push_back(std::move(line));
  }
  return lines;
}

}  // namespace skyquilt::flight
