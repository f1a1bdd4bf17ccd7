#include "core/flight/lists/reflectance_list.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "core/base/try.h"
#include "core/flight/bytes/byte_source.h"
#include "core/flight/bytes/text_fields.h"
#include "core/flight/remarks/because.h"

namespace skyquilt::flight {
namespace {

constexpr std::size_t kMaxBytes = std::size_t{1} << 20;
constexpr std::size_t kMaxRows = 10'000, kMaxBands = 40, kMaxWarnings = 20;
constexpr std::size_t kMaxTargets = 100;  // each is looked at in six captures
constexpr double kMaxRadiusM = 1000.0;

struct Columns {
  std::optional<std::size_t> photo, lat, lon, radius, all;
  std::array<std::optional<std::size_t>, 4> box;
  std::vector<std::pair<std::string, std::size_t>> bands;

  bool HasTargets() const { return lat && lon && radius; }
};

Columns ColumnsOf(const std::vector<std::string_view>& header) {
  Columns columns;
  const std::pair<std::string_view, std::optional<std::size_t>*> known[] = {
      {"photo", &columns.photo},   {"image", &columns.photo},     {"file", &columns.photo},
      {"lat", &columns.lat},       {"lat_deg", &columns.lat},     {"lon", &columns.lon},
      {"lon_deg", &columns.lon},   {"radius_m", &columns.radius}, {"radius", &columns.radius},
      {"left", &columns.box[0]},   {"top", &columns.box[1]},      {"right", &columns.box[2]},
      {"bottom", &columns.box[3]}, {"reflectance", &columns.all}, {"albedo", &columns.all},
  };
  for (std::size_t i = 0; i < header.size(); ++i) {
    const std::string name = LowerCase(header[i]);
    const auto* found = std::find_if(std::begin(known), std::end(known),
                                     [&](const auto& column) { return column.first == name; });
    if (found != std::end(known)) {
      if (!*found->second) *found->second = i;
    } else if (!name.empty() && !IsOneOf(name, {"name", "comment", "note", "serial"}) &&
               columns.bands.size() < kMaxBands) {
      columns.bands.emplace_back(name, i);
    }
  }
  return columns;
}

// One row, and what is wrong with it.
class Row {
 public:
  explicit Row(const std::vector<std::string_view>& fields) : fields_(fields) {}

  std::string_view Text(const std::optional<std::size_t>& column) const {
    return column && *column < fields_.size() ? fields_[*column] : std::string_view();
  }
  std::optional<double> Number(const std::optional<std::size_t>& column) {
    const std::string_view text = Text(column);
    if (text.empty()) return std::nullopt;
    const auto number = ParseNumber(text);
    if (!number) Blame(text, RemarkCode::kIsNoNumber);
    return number;
  }
  std::optional<double> Share(std::size_t column) {
    std::string_view text = Text(column);
    if (text.empty()) return std::nullopt;
    const bool is_percent = text.ends_with('%');
    auto share = ParseNumber(is_percent ? Trim(text.substr(0, text.size() - 1)) : text);
    if (share && is_percent) *share /= 100.0;
    constexpr double kMaxShare = 1.2;  // snow and white panels come out a little above 1
    if (share && *share > 0.0 && *share <= kMaxShare) return share;
    Blame(text, RemarkCode::kIsNoReflectance);
    return std::nullopt;
  }
  const std::optional<Remark>& fault() const { return fault_; }

 private:
  void Blame(std::string_view text, RemarkCode why) {
    if (!fault_) fault_ = Remark{why, {{"cell", Quoted(text)}}};
  }

  const std::vector<std::string_view>& fields_;
  std::optional<Remark> fault_;
};

KnownReflectance ReflectanceOf(const Columns& columns, Row& row) {
  KnownReflectance known;
  if (columns.all) known.all = row.Share(*columns.all);
  for (const auto& [name, column] : columns.bands) {
    if (const auto share = row.Share(column)) known.bands.emplace(name, *share);
  }
  return known;
}

// What is wrong with the row, if anything.
std::optional<Remark> AddRow(const Columns& columns, Row& row, ReflectanceList& list) {
  const KnownReflectance known = ReflectanceOf(columns, row);
  const std::string_view photo = row.Text(columns.photo);
  if (!photo.empty()) {
    PanelInPhoto panel{std::string(photo.substr(0, kMaxNameLength)), std::nullopt, known};
    std::replace(panel.photo.begin(), panel.photo.end(), '\\', '/');
    std::array<double, 4> box{};
    std::size_t sides = 0;
    for (std::size_t k = 0; k < box.size(); ++k) {
      const auto side = row.Number(columns.box[k]);
      if (side) box[k] = *side, ++sides;
    }
    if (row.fault()) return row.fault();
    if (sides != 0 && sides != box.size()) return RemarkCode::kBoxIncomplete;
    if (sides != 0 && !(box[0] < box[2] && box[1] < box[3])) return RemarkCode::kBoxReversed;
    if (sides != 0) panel.box_px = box;
    list.panels.push_back(std::move(panel));
    return std::nullopt;
  }
  const auto lat = row.Number(columns.lat), lon = row.Number(columns.lon),
             radius = row.Number(columns.radius);
  if (row.fault()) return row.fault();
  if (!lat || !lon || !radius) return RemarkCode::kRowNamesNoTarget;
  if (!(*lat >= -90.0 && *lat <= 90.0 && *lon >= -180.0 && *lon <= 180.0))
    return RemarkCode::kPlaceNotOnEarth;
  if (!(*radius > 0.0 && *radius <= kMaxRadiusM))
    return Remark{RemarkCode::kRadiusImpossible, {{"most_m", kMaxRadiusM}}};
  if (!known.all && known.bands.empty()) return RemarkCode::kRowWithoutReflectance;
  if (list.targets.size() == kMaxTargets)
    return Remark{RemarkCode::kOnlyFirstTargets, {{"most", kMaxTargets}}};
  list.targets.push_back({{*lat, *lon}, *radius, known});
  return std::nullopt;
}

}  // namespace

const PanelInPhoto* FindPanelRow(const std::vector<ReflectanceList>& lists, std::string_view photo) {
  if (lists.empty()) return nullptr;
  const std::string wanted = LowerCase(photo);
  for (const ReflectanceList& list : lists) {
    for (const PanelInPhoto& panel : list.panels) {
      const std::string called = LowerCase(panel.photo);
      if (called == wanted || called.ends_with("/" + wanted)) return &panel;
    }
  }
  return nullptr;
}

bool IsReflectanceList(std::string_view name) {
  return LowerCase(name.substr(name.find_last_of('/') + 1)) == kReflectanceListName;
}

Result<ReflectanceList> ParseReflectanceList(std::string_view name, std::string_view text) {
  ReflectanceList list;
  list.file_name = std::string(name);
  LineReader lines(text);
  std::string_view line;
  while (lines.Next(line) && Trim(line).empty()) {
  }
  const char separator = GuessSeparator(line);
  std::vector<std::string_view> fields;
  SplitFields(line, separator, fields);
  const Columns columns = ColumnsOf(fields);
  if (!columns.photo && !columns.HasTargets()) {
    return Because(ErrorCode::kUnsupportedFormat,
                   {RemarkCode::kReflectancesWithoutColumns, {{"file", list.file_name}}});
  }
  std::size_t rows = 0;
  while (lines.Next(line)) {
    if (Trim(line).empty() || Trim(line).starts_with('#')) continue;
    if (++rows > kMaxRows) {
      list.warnings.push_back({RemarkCode::kOnlyFirstRows, {{"most", kMaxRows}}});
      break;
    }
    SplitFields(line, separator, fields);
    Row row(fields);
    auto fault = AddRow(columns, row, list);
    if (fault && list.warnings.size() < kMaxWarnings) {
      list.warnings.push_back(
          {RemarkCode::kOfLine, {{"line", lines.line_number()}, {"why", *std::move(fault)}}});
    }
  }
  if (list.panels.empty() && list.targets.empty()) {
    if (list.warnings.empty())
      return Because(ErrorCode::kCorrupt, {RemarkCode::kReflectancesUnused, {{"file", list.file_name}}});
    return Because(ErrorCode::kCorrupt, {RemarkCode::kReflectancesUnusedAs,
                                         {{"file", list.file_name}, {"why", list.warnings.front()}}});
  }
  return list;
}

Result<ReflectanceList> ReadReflectanceList(const InputFile& file) {
  SKYQUILT_TRY_ASSIGN(const auto mapped, MappedFile::Open(file.path));
  const auto bytes = mapped.bytes();
  if (bytes.size() > kMaxBytes)
    return Because(ErrorCode::kTooLarge, {RemarkCode::kReflectancesTooLarge, {{"file", file.name}}});
  SKYQUILT_TRY_ASSIGN(const auto text, LogText::Of(file.name, bytes));
  return ParseReflectanceList(file.name, TextOf(text.bytes()));
}

}  // namespace skyquilt::flight
