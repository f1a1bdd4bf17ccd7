#include "core/flight/logs/texts/gcp_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <tuple>

#include "core/base/try.h"
#include "core/flight/logs/log_text.h"
#include "core/flight/logs/mapped_file.h"
#include "core/flight/logs/text_fields.h"
#include "core/flight/logs/texts/srs.h"

namespace skyquilt::flight {
namespace {

constexpr std::size_t kMaxSightings = 100'000;
constexpr std::size_t kMaxGcpPoints = 100'000;
constexpr std::size_t kMinFlatPoints = 3;
constexpr std::ptrdiff_t kTabsOfWholeRow = 6;

// With a tab between all seven fields blanks are part of names.
void SplitRow(std::string_view line, std::vector<std::string_view>& words) {
  words.clear();
  if (std::count(line.begin(), line.end(), '\t') >= kTabsOfWholeRow) {
    std::size_t at = 0;
    for (std::ptrdiff_t field = 0; field <= kTabsOfWholeRow && at <= line.size(); ++field) {
      const std::size_t tab = std::min(line.find('\t', at), line.size());
      words.push_back(Trim(line.substr(at, tab - at)));
      at = tab + 1;
    }
    const auto is_empty = [](std::string_view word) { return word.empty(); };
    if (std::none_of(words.begin(), words.end(), is_empty)) return;  // else they only align columns
  }
  SplitBlanks(line, words);
}

// x y z px py image: five numbers, then a name.
bool IsSighting(const std::vector<std::string_view>& words) {
  if (words.size() < 6) return false;
  for (std::size_t i = 0; i < 5; ++i) {
    if (!ParseNumber(words[i]) && !(i == 2 && LowerCase(words[i]) == "nan")) return false;
  }
  return true;
}

// A column has to stand there, and who surveyed no heights fills it with zeros. Points that truly all lie at
// zero lose nothing by it: the map's heights have a zero of their own.
void DropHeightsThatAreFillers(GcpList& list) {
  if (list.points.size() < kMinFlatPoints) return;
  for (const GcpPoint& point : list.points) {
    if (!point.height_m || *point.height_m != 0.0) return;
  }
  for (GcpPoint& point : list.points) {
    point.height_m.reset();
    point.height.reset();
  }
  list.warnings.emplace_back("all heights are 0; they are taken as not surveyed");
}

}  // namespace

bool LooksLikeGcpList(LogBytes head) {
  const std::vector<std::string_view> words = FirstReferencedRow(head);
  return IsSighting(words) && !ParseNumber(words[5]);
}

Result<GcpList> ParseGcpList(std::string_view name, LogBytes bytes) {
  LineReader lines(TextOf(bytes));
  std::string_view line;
  if (!lines.Next(line)) return Error{ErrorCode::kCorrupt, fmt::format("{} is empty.", name), ""};
  SKYQUILT_TRY_ASSIGN(const auto srs, ReferenceSystem::Parse(line));
  GcpList list;
  list.file_name = name;
  list.reference_system = Trim(line);
  std::map<std::tuple<double, double, double>, std::size_t> known;
  std::vector<std::string_view> words;
  while (lines.Next(line) && list.sightings.size() < kMaxSightings && list.points.size() < kMaxGcpPoints) {
    SplitRow(line, words);
    if (words.empty() || words[0].front() == '#') continue;
    const auto refuse = [&](std::string_view why) {
      if (list.warnings.size() < 100)
        list.warnings.push_back(fmt::format("line {}: {}", lines.line_number(), why));
    };
    if (!IsSighting(words)) {
      refuse("not \"x y z pixel_x pixel_y image\"");
      continue;
    }
    const double x = *ParseNumber(words[0]);
    const double y = *ParseNumber(words[1]);
    const auto z = ParseNumber(words[2]);
    const auto [entry, is_new] = known.try_emplace({x, y, z.value_or(-1e9)}, list.points.size());
    if (is_new) {
      const auto position = srs.ToLatLon(x, y);
      if (!position) {
        known.erase(entry);
        refuse(position.error().message);
        continue;
      }
      GcpPoint point;
      point.name = words.size() > 6 ? std::string(words[6].substr(0, kMaxNameLength))
                                    : fmt::format("gcp{}", list.points.size() + 1);
      point.position = *position;
      point.x = x;
      point.y = y;
      point.height = z;
      if (z) point.height_m = *z * srs.metres_per_unit();
      list.points.push_back(std::move(point));
    }
    if (words[5] == kNoImage) continue;
    list.sightings.push_back({std::string(words[5].substr(0, kMaxNameLength)), *ParseNumber(words[3]),
                              *ParseNumber(words[4]), entry->second});
  }
  if ((list.sightings.size() == kMaxSightings || list.points.size() == kMaxGcpPoints) && lines.Next(line))
    list.warnings.push_back(fmt::format("more than {} sightings; the rest was left out", kMaxSightings));
  if (list.points.empty()) {
    return Error{
        ErrorCode::kCorrupt,
        fmt::format("{} holds no ground control point; rows are \"x y z pixel_x pixel_y image\"", name), ""};
  }
  DropHeightsThatAreFillers(list);
  return list;
}

Result<GcpList> ReadGcpList(const InputFile& file) {
  SKYQUILT_TRY_ASSIGN(const auto mapped, MappedFile::Open(file.path));
  SKYQUILT_TRY_ASSIGN(const auto text, LogText::Of(file.name, mapped.bytes()));
  return ParseGcpList(file.name, text.bytes());
}

}  // namespace skyquilt::flight
