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

// "CoordinateSystem:", "CRS:": what stands before the first colon with a blank behind it.
bool SaysSystem(std::string_view label) {
  return HoldsOneOf(LowerCase(label), {"system", "crs", "srs", "projection"});
}

}  // namespace

SystemLine SystemOfLine(std::string_view line, LineReader& lines) {
  const std::string lower = LowerCase(line.substr(0, kLongestSystem));
  if (const std::size_t at = FindDefinition(lower); at != std::string::npos)
    return {WholeSystem(line.substr(at), lines), true};
  if (const auto code = geo::FindEpsgCode(lower)) return {line.substr(code->begin, code->length), true};
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
