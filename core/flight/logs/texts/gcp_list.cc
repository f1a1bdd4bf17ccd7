#include "core/flight/logs/texts/gcp_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <tuple>
#include <utility>

#include "core/base/text/file_names.h"
#include "core/base/try.h"
#include "core/flight/bytes/byte_source.h"
#include "core/flight/bytes/text_fields.h"
#include "core/flight/logs/csv/list_columns.h"
#include "core/flight/logs/log_builder.h"
#include "core/flight/logs/system_line.h"
#include "core/flight/logs/texts/list_rows.h"
#include "core/flight/remarks/because.h"
#include "core/geo/crs/reference_system.h"
#include "core/geo/crs/zoned_easting.h"

namespace skyquilt::flight {
namespace {

constexpr const char* kGcpRowForm = "x y z pixel_x pixel_y image";
constexpr std::size_t kMaxSightings = 100'000;
constexpr std::size_t kMaxGcpPoints = 100'000;
constexpr std::size_t kMinFlatPoints = 3;
constexpr std::size_t kMaxGcpWarnings = 100;
constexpr std::string_view kCheckEnding = "check";
constexpr std::string_view kMarkOfCheck = "_check";
constexpr std::string_view kNoImage = "-";  // of a point that is surveyed and not marked yet
constexpr std::size_t kImageColumn = 5;

// x y z px py image: five numbers, then a name.
bool IsSighting(const std::vector<std::string_view>& words) {
  if (words.size() < 6) return false;
  for (std::size_t i = 0; i < 5; ++i) {
    const auto number = i < 2 ? ParseListCoordinate(words[i]) : ReadBareNumber(words[i]);
    if (!number && !(i == 2 && LowerCase(words[i]) == "nan")) return false;
  }
  return !words[kImageColumn].empty() && !ReadBareNumber(words[kImageColumn]);
}

// "IMG 1 (2).jpg" that blanks have cut is one name: behind the five numbers of a row others belong to it.
void JoinImage(std::string_view line, std::vector<std::string_view>& words) {
  const auto image = words.begin() + kImageColumn;
  const auto last = std::find_if(image, words.end(), IsNamedAsPicture);
  const bool is_cut_at_blanks = line.find_first_of(",;\t") == std::string_view::npos;
  if (!is_cut_at_blanks || *image == kNoImage || last == image || last == words.end()) return;
  *image = {image->data(), static_cast<std::size_t>(last->data() + last->size() - image->data())};
  words.erase(image + 1, last + 1);
}

// Columns of pixels: what tells surveyed points from a log without a line that names a system.
bool HasPixelColumns(const std::vector<std::string_view>& columns) {
  constexpr std::array<std::string_view, 9> kNames = {"im_x",    "imx", "px", "pixel_x", "pixelx",
                                                      "pixel x", "col", "u",  "image_x"};
  return std::any_of(columns.begin(), columns.end(),
                     [&](std::string_view column) { return IsOneOf(LowerCase(column), kNames); });
}

// The number of the column that says which points only check the map; past all columns where none does.
std::size_t CheckColumn(const std::vector<std::string_view>& columns) {
  std::size_t number = 0;
  while (number < columns.size() && LowerCase(Trim(columns[number])) != kCheckEnding) ++number;
  return columns.empty() ? std::string_view::npos : number;
}

// Metres in the unit that the column of heights names ("z (ft)"); nothing where it names none.
std::optional<double> NamedUnitOfHeights(const std::vector<std::string_view>& columns) {
  constexpr std::size_t kHeightColumn = 2;
  if (columns.size() <= kHeightColumn) return std::nullopt;
  const CsvColumn height = MapListColumns({columns[kHeightColumn]}).front();
  return IsHeight(height.meaning) && height.unit_is_written ? std::optional(height.scale) : std::nullopt;
}

bool SaysYes(std::string_view word) {
  return IsOneOf(LowerCase(Trim(word)), {"1", "yes", "true", "x", kCheckEnding});
}

// As written, else by its number; a word after it, or a column, may say that it is to check the map.
std::string NameOfPoint(const std::vector<std::string_view>& words, std::size_t check_column,
                        std::size_t number) {
  constexpr std::size_t kNameColumn = 6;
  const bool has_name =
      words.size() > kNameColumn && !words[kNameColumn].empty() && check_column != kNameColumn;
  std::string name = has_name
                         ? std::string(words[kNameColumn].substr(0, kMaxNameLength - kMarkOfCheck.size()))
                         : fmt::format("gcp{}", number);
  const bool is_said = (check_column < words.size() && SaysYes(words[check_column])) ||
                       (words.size() == kNameColumn + 2 && LowerCase(words.back()) == kCheckEnding);
  return is_said && !IsCheckPoint(name) ? name + std::string(kMarkOfCheck) : name;
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
  list.warnings.emplace_back(RemarkCode::kHeightsNotSurveyed);
}

}  // namespace

bool IsCheckPoint(std::string_view point_name) { return LowerCase(point_name).ends_with(kCheckEnding); }

bool LooksLikeGcpList(LogBytes head) {
  const std::optional<ListTop> top = ReadListTop(TextOf(head), IsSighting);
  if (!top) return false;
  const bool has_pixels = HasPixelColumns(top->columns);
  // Prose that names a picture has several words too.
  const bool names_photo = LooksLikeImageName(top->row[kImageColumn]) && (has_pixels || !top->name_is_joined);
  if (names_photo && (has_pixels || top->columns.empty())) return true;
  return !top->system.empty() && geo::ReferenceSystem::Parse(top->system).ok();
}

Result<GcpList> ParseWrittenGcpList(std::string_view name, LogBytes bytes) {
  const std::string_view text = TextOf(bytes);
  const std::optional<ListTop> top = ReadListTop(text, IsSighting);
  if (!top) {
    return Because(ErrorCode::kCorrupt, {RemarkCode::kPointsEmpty, {{"file", name}}});
  }
  SKYQUILT_TRY_ASSIGN(const auto srs, SystemOfList(name, {top->system, true}));
  auto order = OrderOfColumns(top->columns);
  if (!order) order = OrderOfLetters(top->row[0], top->row[1]);
  const bool is_north_first = order == NamedOrder::kNorthFirst;
  const std::size_t check_column = CheckColumn(top->columns);
  const double height_unit_m = srs ? srs->metres_per_height_unit() : 1.0;
  const double units_per_height = NamedUnitOfHeights(top->columns).value_or(height_unit_m) / height_unit_m;
  GcpList list;
  list.file_name = name;
  list.reference_system = Trim(top->system);
  for (const std::size_t number : top->skipped_lines)
    list.warnings.push_back({RemarkCode::kLineIsNone, {{"line", number}, {"form", kGcpRowForm}}});
  std::size_t heights_beyond = 0;
  double first_beyond_m = 0.0;
  std::map<std::tuple<double, double, double>, std::size_t> known;
  std::vector<std::string_view> words;
  LineReader lines(text.substr(top->row_offset));
  std::string_view line = top->row_line;
  bool has_more = true;
  for (; has_more && list.sightings.size() < kMaxSightings && list.points.size() < kMaxGcpPoints;
       has_more = lines.Next(line)) {
    if (IsBlankOrComment(line)) continue;
    if (!SplitListRow(line, IsSighting, words)) {
      if (list.warnings.size() < kMaxGcpWarnings) {
        list.warnings.push_back({RemarkCode::kLineIsNone,
                                 {{"line", top->row_number + lines.line_number()}, {"form", kGcpRowForm}}});
      }
      continue;
    }
    JoinImage(line, words);
    const double x = *ParseListCoordinate(words[is_north_first ? 1 : 0]);
    const double y = *ParseListCoordinate(words[is_north_first ? 0 : 1]);
    auto z = ReadBareNumber(words[2]);
    if (z) *z *= units_per_height;
    // As in any list, "-9999" and the like are written where there is none.
    if (z && !(*z * height_unit_m >= kLowestHeightM && *z * height_unit_m <= kHighestHeightM)) {
      if (heights_beyond++ == 0) first_beyond_m = *z * height_unit_m;
      z.reset();
    }
    const auto [entry, is_new] = known.try_emplace({x, y, z.value_or(-1e9)}, list.points.size());
    if (is_new) {
      GcpPoint point;
      point.name = NameOfPoint(words, check_column, list.points.size() + 1);
      const auto position = srs ? srs->ToLatLon(geo::EastingIn(*srs, x, y), y) : std::nullopt;
      point.has_position = position.has_value();
      if (position) point.position = *position;
      point.x = x;
      point.y = y;
      point.height = z;
      if (z) point.height_m = *z * height_unit_m;
      list.points.push_back(std::move(point));
    }
    const std::string_view image = words[kImageColumn];
    if (image == kNoImage) continue;
    list.sightings.push_back({std::string(image.substr(0, kMaxNameLength)), *ReadBareNumber(words[3]),
                              *ReadBareNumber(words[4]), entry->second});
  }
  if (has_more && (list.sightings.size() == kMaxSightings || list.points.size() == kMaxGcpPoints))
    list.warnings.push_back({RemarkCode::kSightingsBeyond, {{"most", kMaxSightings}}});
  if (heights_beyond > 0) {
    list.warnings.push_back(
        {RemarkCode::kHeightsBeyond, {{"rows", heights_beyond}, {"height_m", first_beyond_m}}});
  }
  DropHeightsThatAreFillers(list);
  return list;
}

Result<GcpList> OnlyPlaced(GcpList list) {
  if (list.reference_system.empty())
    return Because(ErrorCode::kUnsupportedFormat,
                   {RemarkCode::kPointsNameNoSystem, {{"file", list.file_name}}});
  std::vector<std::optional<std::size_t>> now(list.points.size());
  std::vector<GcpPoint> placed;
  for (std::size_t i = 0; i < list.points.size(); ++i) {
    GcpPoint& point = list.points[i];
    if (point.has_position) {
      now[i] = placed.size();
      placed.push_back(std::move(point));
    } else if (list.warnings.size() < kMaxGcpWarnings) {
      list.warnings.push_back({RemarkCode::kPointOutsideSystem,
                               {{"point", point.name},
                                {"x", point.x},
                                {"y", point.y},
                                {"system", list.reference_system.substr(0, 80)}}});
    }
  }
  std::erase_if(list.sightings, [&](GcpSighting& sighting) {
    const std::optional<std::size_t> point = now[sighting.point];
    if (point) sighting.point = *point;
    return !point;
  });
  list.points = std::move(placed);
  if (!list.points.empty()) return list;
  return Because(ErrorCode::kCorrupt,
                 {RemarkCode::kPointsOutsideSystem,
                  {{"file", list.file_name}, {"system", list.reference_system.substr(0, 80)}}});
}

Result<GcpList> ParseGcpList(std::string_view name, LogBytes bytes) {
  SKYQUILT_TRY_ASSIGN(GcpList list, ParseWrittenGcpList(name, bytes));
  return OnlyPlaced(std::move(list));
}

Result<GcpList> ReadGcpList(const InputFile& file) {
  SKYQUILT_TRY_ASSIGN(GcpList list, ReadWrittenGcpList(file));
  return OnlyPlaced(std::move(list));
}

Result<GcpList> ReadWrittenGcpList(const InputFile& file) {
  SKYQUILT_TRY_ASSIGN(const auto mapped, MappedFile::Open(file.path));
  SKYQUILT_TRY_ASSIGN(const auto text, LogText::Of(file.name, mapped.bytes()));
  return ParseWrittenGcpList(file.name, text.bytes());
}

}  // namespace skyquilt::flight
