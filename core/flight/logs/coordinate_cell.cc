#include "core/flight/logs/coordinate_cell.h"

#include <algorithm>
#include <string>
#include <vector>

#include "core/flight/bytes/text_fields.h"

namespace skyquilt::flight {
namespace {

constexpr std::size_t kLongestCoordinate = 64;

enum class CellToken { kDegree, kMinute, kSecond, kNorth, kSouth, kEast, kWest };

// Words and signs, apart by blanks; longer ones before those they begin with. Not "o": Ost and ouest.
struct TokenTexts {
  CellToken token;
  std::string_view texts;
};
constexpr TokenTexts kTokens[] = {
    {CellToken::kDegree,  // "grad" is German; of UTF-8, also where it was taken for Latin-1 and written anew
     "degrees degree deg. deg grad d \xC3\x82\xC2\xB0 \xC2\xB0 \xC2\xBA \xCB\x9A "
     "\xEF\xBF\xBD "  // what is left of a sign that a program could not read
     "\xB0 \xBA"},    // Latin-1
    {CellToken::kSecond,
     "\"\" \" '' "  // the first doubled inside quotes
     "\xE2\x80\x99\xE2\x80\x99 \xE2\x80\xB2\xE2\x80\xB2 \xE2\x80\xB3 \xE2\x80\x9C \xE2\x80\x9D "
     "\x94 sec"},  // Windows-1252
    {CellToken::kMinute, "' ` \xE2\x80\xB2 \xE2\x80\x98 \xE2\x80\x99 \xC2\xB4 \xB4 \x92 min m"},
    {CellToken::kNorth, "north nord norte n"},
    {CellToken::kSouth,
     "south s\xC3\xBC"
     "d sued sud sur s"},
    {CellToken::kEast, "east este est ost e"},
    {CellToken::kWest, "west ouest oeste w"},
};

struct TokenText {
  std::string_view text;
  CellToken token;
};

std::vector<TokenText> SplitTokens() {
  std::vector<TokenText> tokens;
  std::vector<std::string_view> texts;
  for (const TokenTexts& each : kTokens) {
    SplitBlanks(each.texts, texts);
    for (const std::string_view text : texts) tokens.push_back({text, each.token});
  }
  return tokens;
}

// Degrees, minutes and seconds as they are found, from left to right.
class Sexagesimal {
 public:
  bool is_open() const { return open_.has_value(); }
  bool is_empty() const { return !open_ && last_ < 0; }
  int last() const { return last_; }

  bool Take(double number, bool is_whole) {
    if (open_ && !Place(last_ + 1)) return false;
    open_ = number;
    open_is_whole_ = is_whole;
    return true;
  }
  // The open number counts degrees (0), minutes (1) or seconds (2).
  bool Place(int level) {
    if (!open_ || level > 2 || level <= last_ || (last_ < 0 && level != 0) || has_fraction_) return false;
    if (level > 0 && *open_ >= 60.0) return false;
    degrees_ += *open_ / (level == 0 ? 1.0 : level == 1 ? 60.0 : 3600.0);
    has_fraction_ = !open_is_whole_;
    last_ = level;
    open_.reset();
    return true;
  }
  bool Close() { return !open_ || Place(last_ + 1); }
  double degrees() const { return degrees_; }

 private:
  std::optional<double> open_;
  bool open_is_whole_ = true;
  bool has_fraction_ = false;
  int last_ = -1;
  double degrees_ = 0.0;
};

// Digits with at most one point or comma at `at`.
bool TakePlainNumber(std::string_view cell, std::size_t& at, Sexagesimal& angle) {
  std::string digits;
  bool is_whole = true;
  while (at < cell.size() && IsDigit(cell[at])) digits += cell[at++];
  if (at + 1 < cell.size() && (cell[at] == '.' || cell[at] == ',') && IsDigit(cell[at + 1])) {
    digits += '.';
    is_whole = false;
    for (++at; at < cell.size() && IsDigit(cell[at]);) digits += cell[at++];
  }
  const auto number = ParseNumber(digits);
  return number && angle.Take(*number, is_whole);
}

std::optional<CoordinateCell> ReadSexagesimal(std::string_view cell) {
  const std::string lower = LowerCase(cell);
  const std::string_view text = lower;
  Sexagesimal angle;
  CoordinateCell read;
  bool is_negative = false, has_sign = false, is_over = false, has_letter_minutes = false;
  for (std::size_t at = 0; at < text.size();) {
    const std::string_view rest = text.substr(at);
    if (const std::size_t blank = LengthOfBlank(rest)) {
      at += blank;
      continue;
    }
    if (IsDigit(text[at])) {
      if (is_over || !TakePlainNumber(text, at, angle)) return std::nullopt;
      continue;
    }
    if (text[at] == ':') {
      if (!angle.Place(angle.last() + 1)) return std::nullopt;
      ++at;
      continue;
    }
    const std::size_t minus = LengthOfMinus(rest);
    if (minus > 0 || text[at] == '+') {
      if (has_sign || !angle.is_empty()) return std::nullopt;
      has_sign = true;
      is_negative = minus > 0;
      at += minus > 0 ? minus : 1;
      continue;
    }
    static const std::vector<TokenText> kInOrder = SplitTokens();
    const auto found = std::find_if(kInOrder.begin(), kInOrder.end(),
                                    [&](const TokenText& each) { return rest.starts_with(each.text); });
    if (found == kInOrder.end()) return std::nullopt;
    CellToken token = found->token;
    at += found->text.size();
    // "33s" behind "50m" are seconds; a capital one there could be the south.
    if (found->text == "s" && has_letter_minutes && angle.is_open()) {
      if (cell[at - 1] == 'S' && read.hemisphere == 0 &&
          Trim(text.substr(at)).find_first_of("nsew") == std::string_view::npos)
        return std::nullopt;
      token = CellToken::kSecond;
    }
    if (token <= CellToken::kSecond) {
      if (!angle.Place(static_cast<int>(token))) return std::nullopt;
      has_letter_minutes = has_letter_minutes || found->text == "m";
      continue;
    }
    if (read.hemisphere != 0 || !angle.Close()) return std::nullopt;
    is_over = !angle.is_empty();
    read.hemisphere = "NSEW"[static_cast<int>(token) - static_cast<int>(CellToken::kNorth)];
  }
  if (!angle.Close() || angle.is_empty()) return std::nullopt;
  if (angle.last() > 0 && angle.degrees() > 360.0) return std::nullopt;
  if (is_negative && (read.hemisphere == 'N' || read.hemisphere == 'E')) return std::nullopt;
  is_negative = is_negative || read.hemisphere == 'S' || read.hemisphere == 'W';
  read.value = is_negative ? -angle.degrees() : angle.degrees();
  return read;
}

}  // namespace

std::optional<CoordinateCell> ReadCoordinateCell(std::string_view cell) {
  cell = BareCell(cell);
  if (cell.empty() || cell.size() > kLongestCoordinate) return std::nullopt;
  if (const auto plain = ReadNumber(cell); plain && plain->unit.empty()) return CoordinateCell{plain->value};
  return ReadSexagesimal(cell);
}

}  // namespace skyquilt::flight
