#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "core/base/text/printable.h"
#include "core/base/try.h"
#include "core/flight/bytes/text_fields.h"
#include "core/flight/logs/formats.h"
#include "core/flight/logs/log_builder.h"
#include "core/flight/logs/system_line.h"
#include "core/flight/logs/texts/list_rows.h"
#include "core/geo/crs/reference_system.h"
#include "core/geo/lat_lon.h"

namespace skyquilt::flight {
namespace {

constexpr const char* kGeoRowForm = "image x y z";
constexpr std::uint64_t kMaxRows = 200'000;

// Names may lack their endings.
bool IsGeoRow(const std::vector<std::string_view>& cells) {
  return cells.size() >= 3 && !cells[0].empty() && !ParseListCoordinate(cells[0]) &&
         ParseListCoordinate(cells[1]) && ParseListCoordinate(cells[2]);
}

bool IsCutAtBlanks(std::string_view line) { return line.find_first_of(",;|\t") == std::string_view::npos; }

void TakeAnglesAndSigmas(const std::vector<std::string_view>& cells, CameraEvent& event) {
  const auto number = [&](std::size_t i) {
    return i < cells.size() ? ReadBareNumber(cells[i]) : std::nullopt;
  };
  event.yaw_pitch_roll_rad = YawPitchRollRad(number(4), number(5), number(6));
  event.sigma_in_ned_m = SigmaInNedM(number(7), number(8));
}

// Of old the format had omega, phi and kappa there, and others write roll, pitch and yaw: the third angle
// turns by more than an airframe rolls, the others hardly.
bool TurnsByThirdAngle(const std::vector<CameraEvent>& events) {
  constexpr double kMaxLevelRad = 0.5, kMinTurnedRad = 0.8;
  constexpr std::size_t kFewestRows = 3;
  std::size_t rows = 0, level = 0, turned = 0;
  for (const CameraEvent& event : events) {
    if (!event.yaw_pitch_roll_rad) continue;
    const Eigen::Vector3d& angles_rad = *event.yaw_pitch_roll_rad;
    const auto size_rad = [&](int k) { return std::abs(std::remainder(angles_rad[k], 2.0 * geo::kPi)); };
    ++rows;
    level += size_rad(0) < kMaxLevelRad && size_rad(1) < kMaxLevelRad ? 1 : 0;
    turned += size_rad(2) > kMinTurnedRad ? 1 : 0;
  }
  return rows >= kFewestRows && 4 * level >= 3 * rows && 4 * turned >= rows;
}

}  // namespace

// Below names of columns rows are read by these. Without a line that names the system the rows must be cut at
// blanks: others are read as CSV. Above names without endings, or of several words, the line must name one,
// else it is the title of some other table, and the words are prose.
bool LooksLikeGeoTxt(LogBytes head) {
  const std::optional<ListTop> top = ReadListTop(TextOf(head), IsGeoRow);
  if (!top || AreNamesOfColumns(top->columns)) return false;
  const bool names_file = LooksLikeImageName(top->row[0]) && !top->name_is_joined;
  if (names_file && IsCutAtBlanks(top->row_line)) return true;
  if (top->system.empty() || (top->name_is_joined && !top->skipped_lines.empty())) return false;
  return geo::ReferenceSystem::Parse(top->system).ok();
}

Result<FlightLog> ParseGeoTxt(std::string_view name, LogBytes bytes, const ConsumedUpTo&) {
  LogBuilder builder("geo_txt", name);
  const std::string_view text = TextOf(bytes);
  const std::optional<ListTop> top = ReadListTop(text, IsGeoRow);
  if (!top) return builder.Refuse(RemarkCode::kGeoTxtEmpty);
  SKYQUILT_TRY_ASSIGN(const auto system, SystemOfList(name, {top->system, true}));
  const auto order = OrderOfLetters(top->row[1], top->row[2]);
  const bool is_above_sea = system && system->heights_are_above_sea();
  const double metres_per_height_unit = system ? system->metres_per_height_unit() : 1.0;
  std::vector<std::string_view> cells = top->row;
  LineReader lines(text.substr(top->row_offset));
  std::string_view line = top->row_line;
  std::uint64_t rows = 0;
  std::uint64_t bad = top->skipped_lines.size();
  for (const std::size_t number : top->skipped_lines)
    builder.Warn({RemarkCode::kLineIsNone, {{"line", number}, {"form", kGeoRowForm}}});
  // Counted with the bad ones: each may cost a transformation.
  do {
    if (IsBlankOrComment(line)) continue;
    if (!SplitListRow(line, IsGeoRow, cells)) {
      if (bad++ == 0) {
        builder.Warn({RemarkCode::kLineIsNoneButThis,
                      {{"line", top->row_number + lines.line_number()},
                       {"form", kGeoRowForm},
                       {"text", Quoted(Trim(line), 80)}}});
      }
      continue;
    }
    WrittenPlace written{*ParseListCoordinate(cells[1]), *ParseListCoordinate(cells[2])};
    if (order == NamedOrder::kNorthFirst) std::swap(written.x, written.y);
    CameraEvent event = EventByName(rows, cells[0]);
    event.written = written;
    if (system) event.position = system->ToLatLon(written.x, written.y);
    const auto z = cells.size() > 3 ? ReadBareNumber(cells[3]) : std::nullopt;
    if (z) (is_above_sea ? event.height_amsl_m : event.height_ellipsoid_m) = *z * metres_per_height_unit;
    TakeAnglesAndSigmas(cells, event);
    ++rows;
    builder.Add(std::move(event));
  } while (rows + bad < kMaxRows && lines.Next(line));
  builder.Count("row", rows);
  if (bad > 0) builder.Warn({RemarkCode::kRowsUnread, {{"rows", bad}}});
  if (rows + bad == kMaxRows && lines.Next(line))
    builder.Warn({RemarkCode::kRowsBeyond, {{"most", kMaxRows}}});
  if (system) builder.log().written_system = system->definition();
  builder.log().written_order_is_named = order.has_value();
  builder.log().mapping = {fmt::format("x, y -> {}", system ? system->name() : "no system is named"),
                           is_above_sea ? "z -> height above the sea" : "z -> height above the ellipsoid"};
  if (TurnsByThirdAngle(builder.log().events)) {
    for (CameraEvent& event : builder.log().events) event.yaw_pitch_roll_rad.reset();
    builder.Warn(RemarkCode::kAnglesWithoutHeader);
    builder.log().mapping.emplace_back("no angles");
  } else {
    builder.log().mapping.emplace_back("yaw, pitch, roll -> degrees, pitch 0 = straight down");
  }
  if (metres_per_height_unit != 1.0) {
    builder.log().mapping.push_back(fmt::format("z -> times {} to metres", metres_per_height_unit));
  }
  return std::move(builder).Finish();
}

}  // namespace skyquilt::flight
