#include "core/flight/logs/number_cell.h"

#include <array>
#include <string>

#include "core/flight/bytes/text_fields.h"
#include "core/flight/logs/csv/csv_units.h"

namespace skyquilt::flight {
namespace {

constexpr std::size_t kLongestNumber = 64;

// Length of the first of `marks` that `text` starts with, or 0.
template <std::size_t N>
std::size_t LengthOfFirst(std::string_view text, const std::array<std::string_view, N>& marks) {
  for (const std::string_view mark : marks) {
    if (text.starts_with(mark)) return mark.size();
  }
  return 0;
}

// Between thousands, beside point and comma: a blank, an apostrophe.
std::size_t LengthOfGroupMark(std::string_view text) {
  constexpr std::array<std::string_view, 2> kApostrophes = {"'", "\xE2\x80\x99"};
  const std::size_t blank = LengthOfBlank(text);
  return blank > 0 ? blank : LengthOfFirst(text, kApostrophes);
}

bool IsDegrees(std::string_view words) {
  const CsvUnit* unit = FindUnit(LowerCase(words), Dimension::kCoordinate);
  return unit != nullptr && unit->factor == 1.0;
}

// A number's sign, digits and marks, before it is said which mark is the decimal one.
struct ScannedNumber {
  bool is_negative = false;
  std::string text;  // digits, points and commas; marks of thousands of other kinds left out
  std::string_view rest;
};

std::optional<ScannedNumber> ScanNumber(std::string_view cell) {
  cell = BareCell(cell);
  if (cell.size() > kLongestNumber) return std::nullopt;
  ScannedNumber number;
  std::size_t at = 0;
  if (const std::size_t minus = LengthOfMinus(cell)) {
    number.is_negative = true;
    at = minus;
  } else if (cell.starts_with('+')) {
    at = 1;
  }
  const auto digit_at = [&](std::size_t i) { return i < cell.size() && IsDigit(cell[i]); };
  std::size_t run = 0;  // digits since the last mark
  bool has_mark = false;
  while (at < cell.size()) {
    if (IsDigit(cell[at])) {
      number.text += cell[at++];
      ++run;
    } else if ((cell[at] == '.' || cell[at] == ',') && digit_at(at + 1)) {
      number.text += cell[at++];
      run = 0;
      has_mark = true;
    } else {
      const std::size_t group = LengthOfGroupMark(cell.substr(at));
      const std::size_t next = at + group;
      const bool joins = group > 0 && !has_mark && run >= 1 && run <= 3 && digit_at(next) &&
                         digit_at(next + 1) && digit_at(next + 2) && !digit_at(next + 3);
      if (!joins) break;
      at = next;
      run = 0;
    }
  }
  if (number.text.empty() || number.text.find_first_of("0123456789") == std::string::npos)
    return std::nullopt;
  number.rest = Trim(cell.substr(at));
  constexpr std::string_view kNoUnit = "+-.,0123456789";
  if (!number.rest.empty() && kNoUnit.find(number.rest.front()) != std::string_view::npos)
    return std::nullopt;
  return number;
}

// "1,234,567": one to three digits, then three behind each mark.
bool IsGrouped(std::string_view text, char mark) {
  const std::size_t first = text.find(mark);
  if (first == 0 || first > 3 || text.front() == '0') return false;
  for (std::size_t at = first; at < text.size(); at += 4) {
    if (text[at] != mark || text.size() < at + 4) return false;
    for (std::size_t i = at + 1; i < at + 4; ++i) {
      if (!IsDigit(text[i])) return false;
    }
  }
  return true;
}

struct Marks {
  std::size_t points = 0;
  std::size_t commas = 0;
  char last = 0;
};

Marks MarksOf(std::string_view text) {
  Marks marks;
  for (const char c : text) {
    if (c == '.') ++marks.points;
    if (c == ',') ++marks.commas;
    if (!IsDigit(c)) marks.last = c;
  }
  return marks;
}

// The decimal mark among the marks of a number, 0 where all of them are marks of thousands; nothing where
// they contradict each other.
std::optional<char> DecimalOf(std::string_view text, DecimalMark mark) {
  const Marks marks = MarksOf(text);
  if (marks.last == 0) return '\0';
  if (marks.points > 0 && marks.commas > 0) {
    const char other = marks.last == '.' ? ',' : '.';
    const bool is_once = (marks.last == '.' ? marks.points : marks.commas) == 1;
    return is_once && IsGrouped(text.substr(0, text.rfind(marks.last)), other) ? std::optional(marks.last)
                                                                               : std::nullopt;
  }
  const bool is_grouped = IsGrouped(text, marks.last);
  if (marks.points + marks.commas > 1) return is_grouped ? std::optional('\0') : std::nullopt;
  if (!is_grouped) return marks.last;
  if (mark == DecimalMark::kUnclear) return std::nullopt;
  const DecimalMark other = marks.last == '.' ? DecimalMark::kComma : DecimalMark::kPoint;
  return mark == other ? '\0' : marks.last;
}

}  // namespace

std::size_t LengthOfBlank(std::string_view text) {
  constexpr std::array<std::string_view, 5> kBlanks = {" ", "\t", "\xC2\xA0", "\xE2\x80\xAF", "\xE2\x80\x89"};
  return LengthOfFirst(text, kBlanks);
}

std::size_t LengthOfMinus(std::string_view text) {
  constexpr std::array<std::string_view, 3> kMinuses = {"-", "\xE2\x88\x92", "\xE2\x80\x93"};
  return LengthOfFirst(text, kMinuses);
}

std::string_view BareCell(std::string_view cell) {
  cell = Trim(cell);
  if (cell.size() >= 2 && cell.front() == cell.back() && (cell.front() == '"' || cell.front() == '\''))
    cell = Trim(cell.substr(1, cell.size() - 2));
  if (cell.starts_with('\'')) cell = Trim(cell.substr(1));
  return cell;
}

MarkEvidence EvidenceOfMark(std::string_view cell) {
  const auto number = ScanNumber(cell);
  if (!number) return MarkEvidence::kNone;
  const Marks marks = MarksOf(number->text);
  const auto decimal = DecimalOf(number->text, DecimalMark::kUnknown);
  if (marks.last == 0 || !decimal) return MarkEvidence::kNone;
  if (*decimal == 0) return marks.last == ',' ? MarkEvidence::kPoint : MarkEvidence::kComma;
  const bool is_lone = marks.points + marks.commas == 1 && IsGrouped(number->text, marks.last);
  if (*decimal == '.') return is_lone ? MarkEvidence::kLonePoint : MarkEvidence::kPoint;
  return is_lone ? MarkEvidence::kLoneComma : MarkEvidence::kComma;
}

std::optional<NumberCell> ReadNumber(std::string_view cell, DecimalMark mark) {
  const bool is_plain = mark == DecimalMark::kUnknown || mark == DecimalMark::kPoint ||
                        cell.find_first_of(".,") == std::string_view::npos;
  if (is_plain) {
    if (const auto value = ParseNumber(cell)) return NumberCell{*value, {}};
  }
  const auto number = ScanNumber(cell);
  if (!number) return std::nullopt;
  const auto decimal = DecimalOf(number->text, mark);
  if (!decimal) return std::nullopt;
  std::string digits;
  for (const char c : number->text) {
    if (IsDigit(c)) digits += c;
    if (c == *decimal) digits += '.';
  }
  const auto value = ParseNumber(digits);
  if (!value) return std::nullopt;
  return NumberCell{number->is_negative ? -*value : *value, number->rest};
}

std::optional<double> ReadBareNumber(std::string_view cell) {
  const auto number = ReadNumber(cell);
  return number && number->unit.empty() ? std::optional(number->value) : std::nullopt;
}

std::optional<double> ReadNumberCell(std::string_view cell) {
  const auto number = ReadNumber(cell);
  if (!number) return std::nullopt;
  if (number->unit.empty() || IsDegrees(number->unit)) return number->value;
  const auto factor = FactorOfUnitBehind(number->unit, Dimension::kLength);
  return factor ? std::optional(number->value * *factor) : std::nullopt;
}

}  // namespace skyquilt::flight
