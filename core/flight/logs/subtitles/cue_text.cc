#include "core/flight/logs/subtitles/cue_text.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <utility>
#include <vector>

#include "core/flight/bytes/text_fields.h"

namespace skyquilt::flight {
namespace {

// All texts below are in lower case.

struct CueNumber {
  double value = 0.0;
  int decimals = 0;
  std::string_view behind;  // what follows it, without blanks and a sign of degrees
};

// The number at the start of a text, after blanks and a colon. A comma right between digits is a decimal one.
std::optional<CueNumber> LeadingNumber(std::string_view text) {
  constexpr std::size_t kLongestCueNumber = 40;
  text.remove_prefix(std::min(text.find_first_not_of(" :+"), text.size()));
  std::string number(text.substr(0, kLongestCueNumber));
  const std::size_t mark = number.find_first_not_of("-0123456789");
  if (mark != std::string::npos && mark + 1 < number.size() && number[mark] == ',' &&
      IsDigit(number[mark + 1])) {
    number[mark] = '.';
  }
  double value = 0.0;
  const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), value);
  if (error != std::errc() || !std::isfinite(value)) return std::nullopt;
  const auto size = static_cast<std::size_t>(end - number.data());
  std::string_view behind = Trim(text.substr(size));
  if (behind.starts_with("\xC2\xB0")) behind = Trim(behind.substr(2));
  return CueNumber{value, DecimalPlaces(number.substr(0, size)), behind};
}

// "key : 1.5" anywhere, where no letter stands before the key.
std::optional<CueNumber> KeyNumber(std::string_view text, std::string_view key) {
  for (std::size_t at = text.find(key); at != std::string_view::npos; at = text.find(key, at + 1)) {
    const bool starts = at == 0 || !((text[at - 1] >= 'a' && text[at - 1] <= 'z') || text[at - 1] == '_' ||
                                     text[at - 1] == '.');
    const std::string_view rest = text.substr(at + key.size());
    const bool ends = !rest.empty() && (rest.front() == ' ' || rest.front() == ':');
    if (!starts || !ends) continue;
    if (const auto number = LeadingNumber(rest)) return number;
  }
  return std::nullopt;
}

std::optional<double> KeyHeightM(std::string_view text, std::string_view key) {
  constexpr double kFootM = 0.3048;
  const auto number = KeyNumber(text, key);
  if (!number) return std::nullopt;
  return number->behind.starts_with("ft") ? number->value * kFootM : number->value;
}

// "w: -91.99", "46.8n", "12.0m": a number and the letter, if any, that says what it is.
struct Part {
  CueNumber number;
  char letter = 0;
};

// The parts of a call. "8,5,47,25,15" has commas for decimal points as well as between its numbers, and
// without this would be another place on Earth.
std::vector<std::string> PartsOf(std::string_view call) {
  constexpr std::size_t kPlaceWords = 4;  // degrees and their decimals, twice
  const auto is_decimals = [](std::string_view word) {
    return !word.empty() && std::all_of(word.begin(), word.end(), IsDigit);
  };
  std::vector<std::string_view> words;
  SplitFields(call, ',', words);
  std::vector<std::string> parts(words.begin(), words.end());
  if (call.find('.') != std::string_view::npos || words.size() <= kPlaceWords || !is_decimals(words[1]) ||
      !is_decimals(words[3]))
    return parts;
  std::vector<std::string> joined;
  for (std::size_t i = 0; i < parts.size(); i += 2)
    joined.push_back(i + 1 < parts.size() ? parts[i] + "." + parts[i + 1] : parts[i]);
  return joined;
}

// The three parts of "gps(1.5,2.5,19)" or "f.pry (2.7 deg, ...)"; more may follow.
std::optional<std::array<Part, 3>> CallParts(std::string_view text, std::string_view key) {
  constexpr int kTries = 8;
  constexpr std::size_t kLongestCall = 200;
  std::size_t at = text.find(key);
  for (int i = 0; i < kTries && at != std::string_view::npos; ++i, at = text.find(key, at + 1)) {
    std::string_view call = Trim(text.substr(at + key.size(), kLongestCall));
    if (call.starts_with(':')) call = Trim(call.substr(1));
    const std::size_t close = call.find(')');
    if (!call.starts_with('(') || close == std::string_view::npos) continue;
    const std::vector<std::string> words = PartsOf(call.substr(1, close - 1));
    std::array<Part, 3> parts;
    std::size_t read = 0;
    for (; read < parts.size() && read < words.size(); ++read) {
      std::string_view word = words[read];
      const bool is_named =
          !word.empty() && std::string_view("nsew").find(word.front()) != std::string_view::npos;
      if (is_named) parts[read].letter = word.front();
      const auto number = LeadingNumber(word.substr(is_named ? 1 : 0));
      if (!number) break;
      parts[read].number = *number;
      if (!is_named && !number->behind.empty()) parts[read].letter = number->behind.front();
      parts[read].number.behind = {};  // of a word that goes
    }
    if (read == parts.size()) return parts;
  }
  return std::nullopt;
}

bool IsEither(char letter, char a, char b) { return letter == a || letter == b; }

// South and west count down, whether or not a sign says so once more.
double Signed(const Part& part) {
  return IsEither(part.letter, 's', 'w') ? -std::abs(part.number.value) : part.number.value;
}

void TakePlace(std::string_view text, CueFacts& facts) {
  if (const auto gps = CallParts(text, "gps")) {
    const auto& [first, second, third] = *gps;
    facts.decimals = first.number.decimals;
    const bool first_is_lat = IsEither(first.letter, 'n', 's') || IsEither(second.letter, 'e', 'w');
    const bool is_named =
        first_is_lat || IsEither(first.letter, 'e', 'w') || IsEither(second.letter, 'n', 's');
    // Without letters longitude comes first, but latitude where the third value is a height in metres.
    double lat = Signed(second);
    double lon = Signed(first);
    if (is_named ? first_is_lat : third.letter == 'm') std::swap(lat, lon);
    if (!is_named && std::abs(lat) > 90.0 && std::abs(lon) <= 90.0) std::swap(lat, lon);
    facts.position = geo::LatLon{lat, lon};
    if (is_named) facts.height_amsl_m = third.number.value;
    return;
  }
  const auto lat = KeyNumber(text, "latitude");
  auto lon = KeyNumber(text, "longitude");
  if (!lon) lon = KeyNumber(text, "longtitude");  // as some firmware spells it
  if (!lat || !lon) return;
  facts.position = geo::LatLon{lat->value, lon->value};
  facts.decimals = lat->decimals;
}

std::optional<Eigen::Vector3d> PitchRollYaw(std::string_view text, std::string_view key) {
  const auto parts = CallParts(text, key);
  if (!parts) return std::nullopt;
  const auto& [pitch, roll, yaw] = *parts;
  return Eigen::Vector3d(yaw.number.value, pitch.number.value, roll.number.value);
}

}  // namespace

CueFacts ReadCue(std::string_view cue) {
  const std::string text = LowerCase(cue);
  CueFacts facts;
  TakePlace(text, facts);
  for (const std::string_view key : {"altitude", "abs_alt"}) {
    if (const auto height_m = KeyHeightM(text, key)) facts.height_amsl_m = height_m;
  }
  for (const std::string_view key : {"rel_alt", "barometer", "reh", "hb", "h"}) {
    if (facts.height_above_takeoff_m) break;
    facts.height_above_takeoff_m = KeyHeightM(text, key);
  }
  facts.airframe_yaw_pitch_roll_deg = PitchRollYaw(text, "f.pry");
  facts.gimbal_yaw_pitch_roll_deg = PitchRollYaw(text, "g.pry");
  if (!facts.gimbal_yaw_pitch_roll_deg) {
    const auto yaw = KeyNumber(text, "gb_yaw");
    const auto pitch = KeyNumber(text, "gb_pitch");
    const auto roll = KeyNumber(text, "gb_roll");
    if (yaw && pitch && roll)
      facts.gimbal_yaw_pitch_roll_deg = Eigen::Vector3d(yaw->value, pitch->value, roll->value);
  }
  return facts;
}

std::optional<WrittenTime> CueDate(std::string_view text) {
  constexpr std::size_t kShortest = 14;
  constexpr std::size_t kLongest = 32;
  // It starts with four digits and a separator.
  for (std::size_t i = text.find("20"); i != std::string_view::npos && i + kShortest < text.size();
       i = text.find("20", i + 1)) {
    const bool is_fresh = i == 0 || text[i - 1] < '0' || text[i - 1] > '9';
    if (!is_fresh || std::string_view(".-/").find(text[i + 4]) == std::string_view::npos) continue;
    const std::string_view date = text.substr(i, kLongest);
    if (auto written = ParseWrittenTime(date.substr(0, date.find_first_of("\n<)")))) return written;
  }
  return std::nullopt;
}

}  // namespace skyquilt::flight
