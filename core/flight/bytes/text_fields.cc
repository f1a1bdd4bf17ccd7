#include "core/flight/bytes/text_fields.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/base/text/printable.h"

namespace skyquilt::flight {
namespace {

constexpr std::size_t kLongestLine = std::size_t{1} << 20;
constexpr std::size_t kMaxFields = 1024;

bool IsBlank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

std::string_view Unquote(std::string_view field) {
  field = Trim(field);
  if (field.size() >= 2 && field.front() == '"' && field.back() == '"')
    field = field.substr(1, field.size() - 2);
  return Trim(field);
}

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

}  // namespace

std::string_view Trim(std::string_view text) {
  while (!text.empty() && IsBlank(text.front())) text.remove_prefix(1);
  while (!text.empty() && IsBlank(text.back())) text.remove_suffix(1);
  return text;
}

std::string LowerCase(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return lower;
}

bool StartsWithIgnoringCase(std::string_view text, std::string_view start) {
  return text.size() >= start.size() && LowerCase(text.substr(0, start.size())) == LowerCase(start);
}

std::optional<double> ParseNumber(std::string_view text) {
  text = Trim(text);
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  if (text.empty()) return std::nullopt;
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::optional<std::int64_t> ParseInteger(std::string_view text) {
  text = Trim(text);
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

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

void SplitBlanks(std::string_view line, std::vector<std::string_view>& fields) {
  fields.clear();
  std::size_t at = 0;
  while (at < line.size() && fields.size() < kMaxFields) {
    while (at < line.size() && IsBlank(line[at])) ++at;
    const std::size_t start = at;
    while (at < line.size() && !IsBlank(line[at])) ++at;
    if (at > start) fields.push_back(line.substr(start, at - start));
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

bool LooksLikeText(std::string_view head) {
  if (head.empty()) return false;
  const auto control = std::count_if(head.begin(), head.end(), [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return byte < 0x20 && !IsBlank(c) && byte != 0x0C;
  });
  return control == 0;
}

}  // namespace skyquilt::flight
