#include "core/flight/bytes/text_fields.h"

#include <cmath>

#include "core/base/text/printable.h"
#include "core/flight/remarks/because.h"

namespace skyquilt::flight {
namespace {

constexpr std::size_t kLongestLine = std::size_t{1} << 20;
constexpr std::size_t kMaxFields = 1024;

// Where the field ends whose opening quote stands before `from`: at a separator or the line's end behind a
// closing quote; doubled quotes are part of the field. npos where the quote is none that closes.
std::size_t EndOfQuotedField(std::string_view line, std::size_t from, char separator) {
  while (true) {
    const std::size_t quote = line.find('"', from);
    if (quote == std::string_view::npos) return quote;
    from = std::min(line.find_first_not_of('"', quote), line.size());
    if ((from - quote) % 2 == 0) continue;
    std::size_t end = from;
    while (end < line.size() && line[end] != separator && IsBlank(line[end])) ++end;
    if (end == line.size() || line[end] == separator) return end;
  }
}

// The whole text but for blanks around it.
template <typename Number>
std::optional<Number> ParseWhole(std::string_view text) {
  text = Trim(text);
  if (text.starts_with('+')) text.remove_prefix(1);
  return skyquilt::ParseNumber<Number>(text);
}

}  // namespace

std::string_view Unquote(std::string_view field) {
  field = Trim(field);
  if (field.size() >= 2 && field.front() == '"' && field.back() == '"')
    field = field.substr(1, field.size() - 2);
  return Trim(field);
}

bool StartsWithIgnoringCase(std::string_view text, std::string_view start) {
  return text.size() >= start.size() && LowerCase(text.substr(0, start.size())) == LowerCase(start);
}

std::optional<double> ParseNumber(std::string_view text) {
  const auto value = ParseWhole<double>(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

std::optional<std::int64_t> ParseInteger(std::string_view text) { return ParseWhole<std::int64_t>(text); }

int DecimalPlaces(std::string_view text) {
  const std::size_t point = text.find('.');
  if (point == std::string_view::npos) return 0;
  int places = 0;
  for (std::size_t i = point + 1; i < text.size() && IsDigit(text[i]); ++i) ++places;
  return places;
}

LineReader::LineReader(std::string_view text) : text_(text) {
  if (text_.substr(0, 3) == "\xEF\xBB\xBF") at_ = 3;
}

bool LineReader::Next(std::string_view& line) {
  if (at_ >= text_.size()) return false;
  const std::string_view rest = text_.substr(at_, kLongestLine);
  const std::size_t end = rest.find_first_of("\r\n");
  ++number_;
  if (end == std::string_view::npos) {
    line = rest;
    at_ += rest.size();
    open_ = at_ >= text_.size();
    return true;
  }
  line = rest.substr(0, end);
  at_ += end + 1;
  if (rest[end] == '\r' && at_ < text_.size() && text_[at_] == '\n') ++at_;
  open_ = false;
  return true;
}

void SplitFields(std::string_view line, char separator, std::vector<std::string_view>& fields) {
  if (separator == ' ') return SplitBlanks(line, fields);
  fields.clear();
  bool quotes_close = true;  // false from the first that does not: each is looked at once
  for (std::size_t start = 0; start <= line.size() && fields.size() < kMaxFields;) {
    std::size_t first = start;
    while (first < line.size() && line[first] != separator && IsBlank(line[first])) ++first;
    std::size_t end = std::string_view::npos;
    if (quotes_close && first < line.size() && line[first] == '"') {
      end = EndOfQuotedField(line, first + 1, separator);
      quotes_close = end != std::string_view::npos;
    }
    if (end == std::string_view::npos) end = std::min(line.find(separator, first), line.size());
    fields.push_back(Unquote(line.substr(start, end - start)));
    start = end + 1;
  }
}

bool NextRow(LineReader& lines, char separator, std::vector<std::string_view>& cells, std::size_t end) {
  std::string_view line;
  while (lines.offset() < end && lines.Next(line)) {
    if (IsBlankOrComment(line)) continue;
    SplitFields(line, separator, cells);
    return true;
  }
  return false;
}

void SplitBlanks(std::string_view line, std::vector<std::string_view>& fields, std::string_view blanks) {
  fields.clear();
  std::size_t at = line.find_first_not_of(blanks);
  while (at != std::string_view::npos && fields.size() < kMaxFields) {
    const std::size_t end = std::min(line.find_first_of(blanks, at), line.size());
    fields.push_back(line.substr(at, end - at));
    at = line.find_first_not_of(blanks, end);
  }
}

char GuessSeparator(std::string_view header) {
  // What stands in brackets is a unit: "Latitude (deg, WGS84)"; a comma between digits may be a decimal one.
  int depth = 0;
  std::ptrdiff_t commas = 0, decimal_commas = 0, semicolons = 0, tabs = 0, pipes = 0;
  const auto is_digit_at = [&](std::size_t i) { return i < header.size() && IsDigit(header[i]); };
  for (std::size_t i = 0; i < header.size(); ++i) {
    const char c = header[i];
    if (c == '(' || c == '[') ++depth;
    if ((c == ')' || c == ']') && depth > 0) --depth;
    if (depth > 0 && c != '\t') continue;
    commas += c == ',';
    decimal_commas += c == ',' && i > 0 && is_digit_at(i - 1) && is_digit_at(i + 1);
    semicolons += c == ';';
    tabs += c == '\t';
    pipes += c == '|';
  }
  if (semicolons + tabs + pipes > 0) commas -= decimal_commas;
  if (tabs > commas && tabs >= semicolons && tabs >= pipes) return '\t';
  if (pipes > commas && pipes > semicolons) return '|';
  return semicolons > commas ? ';' : ',';
}

std::string Quoted(std::string_view text, std::size_t longest) {
  const bool is_cut = text.size() > longest;
  text = text.substr(0, longest);
  const auto is_inside_letter = [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) == 0x80U; };
  if (is_cut) {
    while (!text.empty() && is_inside_letter(text.back())) text.remove_suffix(1);
    if (!text.empty() && static_cast<unsigned char>(text.back()) >= 0xC0U) text.remove_suffix(1);
  }
  return "\"" + Printable(std::string(text)) + (is_cut ? "...\"" : "\"");
}

void AppendUtf8(std::uint32_t code, std::string& text) {
  const auto put = [&](std::uint32_t byte) { text += static_cast<char>(static_cast<std::uint8_t>(byte)); };
  if (code < 0x80) return put(code);
  if (code < 0x800) {
    put(0xC0U | (code >> 6U));
  } else {
    if (code < 0x10000) {
      put(0xE0U | (code >> 12U));
    } else {
      put(0xF0U | (code >> 18U));
      put(0x80U | ((code >> 12U) & 0x3FU));
    }
    put(0x80U | ((code >> 6U) & 0x3FU));
  }
  put(0x80U | (code & 0x3FU));
}

bool LooksLikeText(std::string_view head) {
  return !head.empty() && std::none_of(head.begin(), head.end(), [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return byte < 0x20 && !IsBlank(c) && byte != 0x0C;
  });
}

namespace {

constexpr std::size_t kMaxUtf16Bytes = std::size_t{64} << 20;

struct Utf16 {
  bool is_big_endian = false;
  std::size_t begin = 0;  // behind the byte-order mark
};

// Without a mark: at least 16 bytes, of which one of each two is zero and the other a letter of text.
std::optional<Utf16> RecogniseUnmarked(LogBytes bytes) {
  constexpr std::size_t kMinBytes = 16, kLooked = 256;
  if (bytes.size() < kMinBytes) return std::nullopt;
  const std::size_t looked = std::min(bytes.size(), kLooked) / 2 * 2;
  for (const bool is_big_endian : {false, true}) {
    bool fits = true;
    for (std::size_t i = 0; i < looked && fits; i += 2) {
      const std::uint8_t low = bytes[i + (is_big_endian ? 1 : 0)];
      const std::uint8_t high = bytes[i + (is_big_endian ? 0 : 1)];
      fits = high == 0 && (low >= 0x20 || (low >= 0x09 && low <= 0x0D));
    }
    if (fits) return Utf16{is_big_endian, 0};
  }
  return std::nullopt;
}

std::optional<Utf16> RecogniseUtf16(LogBytes bytes) {
  if (bytes.size() >= 4 && bytes[0] == 0xFF && bytes[1] == 0xFE && (bytes[2] != 0 || bytes[3] != 0))
    return Utf16{false, 2};  // with two zeros behind it, it is UTF-32
  if (bytes.size() >= 4 && bytes[0] == 0xFE && bytes[1] == 0xFF) return Utf16{true, 2};
  return RecogniseUnmarked(bytes);
}

std::string DecodeUtf16(LogBytes bytes, const Utf16& kind) {
  const auto unit_at = [&](std::size_t i) {
    return static_cast<std::uint32_t>(UnsignedAt(bytes.data() + i, 2, kind.is_big_endian));
  };
  constexpr std::uint32_t kReplacement = 0xFFFD;
  std::string text;
  text.reserve(bytes.size() / 2);
  for (std::size_t i = kind.begin; i + 1 < bytes.size(); i += 2) {
    std::uint32_t code = unit_at(i);
    if (code >= 0xD800 && code < 0xE000) {
      const std::uint32_t next = i + 3 < bytes.size() ? unit_at(i + 2) : 0;
      const bool is_pair = code < 0xDC00 && next >= 0xDC00 && next < 0xE000;
      code = is_pair ? 0x10000U + ((code - 0xD800U) << 10U) + (next - 0xDC00U) : kReplacement;
      if (is_pair) i += 2;
    }
    AppendUtf8(code, text);
  }
  return text;
}

}  // namespace

Result<LogText> LogText::Of(std::string_view name, LogBytes bytes) {
  LogText text;
  constexpr std::string_view kUtf8Mark = "\xEF\xBB\xBF";
  text.raw_ = TextOf(bytes).starts_with(kUtf8Mark) ? bytes.subspan(kUtf8Mark.size()) : bytes;
  const auto kind = RecogniseUtf16(bytes);
  if (!kind) return text;
  if (bytes.size() > kMaxUtf16Bytes) {
    return Because(
        ErrorCode::kUnsupportedFormat,
        {RemarkCode::kTextTooLarge,
         {{"file", name}, {"size_mib", bytes.size() >> 20U}, {"most_mib", kMaxUtf16Bytes >> 20U}}});
  }
  text.decoded_ = DecodeUtf16(bytes, *kind);
  text.is_decoded_ = true;
  return text;
}

}  // namespace skyquilt::flight
