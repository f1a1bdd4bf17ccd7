#include "core/flight/logs/system_line.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "core/flight/remarks/because.h"

namespace skyquilt::flight {
namespace {

constexpr std::size_t kLongestSystem = 16'384;
constexpr int kMaxWktLines = 200;

std::ptrdiff_t Depth(std::string_view text) {
  return std::count(text.begin(), text.end(), '[') - std::count(text.begin(), text.end(), ']');
}

// WKT may go on over several lines: to where its brackets are closed.
std::string_view WholeSystem(std::string_view first, LineReader& lines) {
  std::ptrdiff_t depth = Depth(first);
  if (depth <= 0) return first;
  LineReader ahead = lines;
  std::string_view line;
  for (int i = 0; i < kMaxWktLines && ahead.Next(line); ++i) {
    const auto length = static_cast<std::size_t>(line.data() + line.size() - first.data());
    if (length > kLongestSystem) break;
    depth += Depth(line);
    if (depth > 0) continue;
    lines = ahead;
    return {first.data(), length};
  }
  return first;
}

// Where WKT or a string of PROJ begins; past the end where neither does.
std::size_t FindDefinition(const std::string& lower) {
  constexpr std::array<std::string_view, 12> kBegin = {
      "projcs[",      "projcrs[",  "geogcs[",        "geogcrs[",      "geodcrs[",  "compd_cs[",
      "compoundcrs[", "boundcrs[", "geographiccrs[", "projectedcrs[", "local_cs[", "+proj="};
  std::size_t first = std::string::npos;
  for (const std::string_view begin : kBegin) first = std::min(first, lower.find(begin));
  return first;
}

// "epsg:32615", "EPSG::32615", "epsg 32615+5773", "EPSG::32615,crs:EPSG::5773" of a URN, wherever it stands
// in `line`.
std::string_view CodeIn(std::string_view line, const std::string& lower) {
  constexpr std::size_t kFewestDigits = 4;
  constexpr std::string_view kBetween = " :=-_/.";
  const std::size_t begin = lower.find("epsg");
  if (begin == std::string::npos) return {};
  const auto past = [&](std::size_t at, auto is_meant) {
    while (at < lower.size() && is_meant(lower[at])) ++at;
    return at;
  };
  const auto is_between = [&](char c) { return kBetween.find(c) != std::string_view::npos; };
  const auto is_blank = [](char c) { return c == ' '; };
  const auto past_code = [&](std::size_t at) {
    if (lower.compare(at, 4, "epsg") == 0) at += 4;
    at = past(at, is_between);
    if (lower.compare(at, 2, "0/") == 0) at += 2;  // ".../crs/epsg/0/32615"
    const std::size_t end = past(at, IsDigit);
    return end - at < kFewestDigits ? std::string::npos : end;
  };
  const std::size_t end = past_code(begin);
  if (end == std::string::npos) return {};
  const std::size_t joined = past(end, is_blank);
  std::size_t vertical = std::string::npos;  // the code of the heights
  if (joined < lower.size() && lower[joined] == '+') vertical = past(joined + 1, is_blank);
  for (const std::string_view join : {",crs:", "&2="}) {  // of URNs and of URLs
    if (lower.compare(joined, join.size(), join) == 0)
      vertical = std::min(lower.find("epsg", joined), lower.size());
  }
  if (vertical == std::string::npos) return line.substr(begin, end - begin);
  return line.substr(begin, std::min(past_code(vertical), line.size()) - begin);
}

// "CoordinateSystem:", "CRS:": what stands before the first colon with a blank behind it.
bool SaysSystem(std::string_view label) {
  return HoldsOneOf(LowerCase(label), {"system", "crs", "srs", "projection"});
}

}  // namespace

SystemLine SystemOfLine(std::string_view line, LineReader& lines) {
  const std::string lower = LowerCase(line.substr(0, kLongestSystem));
  if (const std::size_t at = FindDefinition(lower); at != std::string::npos)
    return {WholeSystem(line.substr(at), lines), true};
  if (const std::string_view code = CodeIn(line, lower); !code.empty()) return {code, true};
  const bool is_comment = line.starts_with('#');
  const std::size_t colon = line.substr(0, kLongestSystem).find(": ");
  if (colon != std::string_view::npos && SaysSystem(line.substr(0, colon)))
    return {Trim(line.substr(colon + 1)), false};
  return {is_comment ? std::string_view() : Trim(line), false};
}

bool TakeSystem(const SystemLine& line, SystemLine& system) {
  const bool is_better =
      !line.text.empty() && (system.text.empty() || (line.is_certain && !system.is_certain));
  if (is_better) system = line;
  return is_better;
}

Result<std::optional<geo::ReferenceSystem>> SystemOfList(std::string_view file, const SystemLine& line) {
  std::optional<geo::ReferenceSystem> system;
  if (line.text.empty()) return system;
  auto named = geo::ReferenceSystem::Parse(line.text);
  if (named) {
    system = *std::move(named);
  } else if (line.is_certain) {
    constexpr std::size_t kQuotedSystem = 80;
    return Because(
        ErrorCode::kUnsupportedFormat,
        {RemarkCode::kSystemUnknown, {{"file", file}, {"system", Quoted(Trim(line.text), kQuotedSystem)}}});
  }
  return system;
}

}  // namespace skyquilt::flight
