#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <optional>

#include "core/base/text/printable.h"
#include "core/flight/bytes/text_fields.h"
#include "core/flight/logs/formats.h"
#include "core/flight/logs/log_builder.h"
#include "core/flight/logs/texts/list_rows.h"
#include "core/flight/remarks/because.h"

namespace skyquilt::flight {
namespace {

enum class Angles { kNone, kUnnamed, kYawPitchRoll, kOmegaPhiKappa };

struct Columns {
  std::size_t angles_at = 0;
  std::size_t accuracy_at = 0;  // 0: none
  Angles angles = Angles::kNone;
  // How the two coordinates stand where the header or letters say it; else as the format has it (degrees:
  // latitude first; metres: east first).
  std::optional<NamedOrder> order;
};

bool IsRow(const std::vector<std::string_view>& cells) {
  return cells.size() >= 4 && cells.size() <= 12 && LooksLikePhotoFile(cells[0]) &&
         ParseListCoordinate(cells[1]) && ParseListCoordinate(cells[2]) && ReadBareNumber(cells[3]);
}

bool IsInDegrees(double first, double second) {
  return std::abs(first) <= 180.0 && std::abs(second) <= 180.0;
}

// The names of the columns where the line has them: image, two coordinates, a height, in this order. Others
// are read as CSV, by their names.
std::vector<std::string> HeaderOf(std::string_view line) {
  std::vector<std::string_view> cells;
  const std::string lower = LowerCase(line);
  SplitFields(lower, GuessSeparator(lower), cells);
  std::vector<std::string> names;
  for (const std::string_view cell : cells) {
    const std::size_t begin = cell.find_first_not_of("# \"");
    names.emplace_back(begin == std::string_view::npos ? cell : cell.substr(begin));
  }
  const auto starts = [&](std::size_t i, std::initializer_list<std::string_view> words) {
    return std::any_of(words.begin(), words.end(),
                       [&](std::string_view w) { return names[i].starts_with(w); });
  };
  // A list of Pix4D's has heights above the ellipsoid, in metres; other ones say what theirs are. Metres of a
  // plane are read nowhere else.
  constexpr std::array<std::string_view, 9> kOther = {"ft",  "feet",   "takeoff", "take-off", "take_off",
                                                      "rel", "ground", "msl",     "sea"};
  const auto is_other = [&](std::string_view word) { return names[3].find(word) != std::string::npos; };
  const bool is_header =
      names.size() >= 4 && names[0].starts_with("image") &&
      starts(1, {"latitude", "longitude", "east", "north", "x", "y", "coordinate"}) &&
      starts(2, {"latitude", "longitude", "east", "north", "x", "y", "coordinate"}) &&
      starts(3, {"alt", "z", "height", "elev", "coordinate"}) &&
      std::none_of(kOther.begin(), kOther.begin() + 2, is_other) &&
      (!starts(1, {"latitude", "longitude"}) || std::none_of(kOther.begin(), kOther.end(), is_other));
  if (!is_header) names.clear();
  return names;
}

// The header decides what columns five to nine mean; without one their number does.
Columns ColumnsOf(const std::vector<std::string>& header, std::size_t count) {
  Columns columns;
  if (header.empty()) {
    if (count >= 7) columns.angles = Angles::kUnnamed;
    columns.angles_at = 4;
    columns.accuracy_at = count >= 9 ? 7 : (count == 6 ? 4 : 0);
    return columns;
  }
  for (std::size_t i = 4; i < header.size(); ++i) {
    const auto has = [&](std::string_view word) { return header[i].find(word) != std::string::npos; };
    if (has("yaw") && i + 2 < header.size()) {
      columns.angles_at = i;
      columns.angles = Angles::kYawPitchRoll;
    }
    if (has("omega") && i + 2 < header.size()) {
      columns.angles_at = i;
      columns.angles = Angles::kOmegaPhiKappa;
    }
    if (has("acc") && columns.accuracy_at == 0) columns.accuracy_at = i;
  }
  columns.order = OrderOfColumns({header[1], header[2]});
  return columns;
}

WrittenPlace PlaceOfCells(double first, double second, std::optional<NamedOrder> order) {
  const bool is_north_first = order ? *order == NamedOrder::kNorthFirst : IsInDegrees(first, second);
  return is_north_first ? WrittenPlace{second, first} : WrittenPlace{first, second};
}

// Omega-phi-kappa turns the photogrammetric camera (x right, y up, z back) into east, north, up. The body
// whose camera looks down has x = camera y, y = camera x, z = -camera z.
Eigen::Vector3d YawPitchRollFromOpk(double omega_rad, double phi_rad, double kappa_rad) {
  const Eigen::Matrix3d enu_from_camera = (Eigen::AngleAxisd(omega_rad, Eigen::Vector3d::UnitX()) *
                                           Eigen::AngleAxisd(phi_rad, Eigen::Vector3d::UnitY()) *
                                           Eigen::AngleAxisd(kappa_rad, Eigen::Vector3d::UnitZ()))
                                              .toRotationMatrix();
  Eigen::Matrix3d swap;
  swap << 0, 1, 0, 1, 0, 0, 0, 0, -1;
  return YawPitchRollFromNed(Eigen::Quaterniond(Eigen::Matrix3d(swap * enu_from_camera * swap)));
}

}  // namespace

bool LooksLikePix4dCsv(LogBytes head) {
  LineReader lines(TextOf(head));
  std::string_view line;
  std::vector<std::string_view> cells;
  for (int i = 0; i < 8 && lines.Next(line); ++i) {
    if (Trim(line).empty()) continue;
    SplitFields(line, GuessSeparator(line), cells);
    if (IsRow(cells)) return true;
    if (line.front() != '#' && HeaderOf(line).empty()) return false;
  }
  return false;
}

Result<FlightLog> ParsePix4dCsv(std::string_view name, LogBytes bytes, const ConsumedUpTo&) {
  LogBuilder builder("pix4d_csv", name);
  LineReader lines(TextOf(bytes));
  std::string_view line;
  std::vector<std::string> header;
  std::optional<Columns> columns;
  std::vector<std::string_view> cells;
  std::uint64_t rows = 0;
  std::uint64_t bad = 0;
  bool is_in_degrees = true;
  while (lines.Next(line)) {
    if (Trim(line).empty()) continue;
    SplitFields(line, GuessSeparator(line), cells);
    if (!IsRow(cells)) {
      if (rows == 0 && header.empty()) header = HeaderOf(line);
      if (rows > 0 && line.front() != '#') {
        if (bad++ > 0) continue;
        builder.Warn({RemarkCode::kLineIsNoneButThis,
                      {{"line", lines.line_number()},
                       {"form", "image,latitude,longitude,height"},
                       {"text", Quoted(Trim(line), 80)}}});
      }
      continue;
    }
    if (!columns) {
      columns = ColumnsOf(header, cells.size());
      if (!columns->order) columns->order = OrderOfLetters(cells[1], cells[2]);
    }
    const auto number = [&](std::size_t i) {
      return i < cells.size() ? ReadBareNumber(cells[i]) : std::nullopt;
    };
    const double first = *ParseListCoordinate(cells[1]), second = *ParseListCoordinate(cells[2]);
    is_in_degrees = is_in_degrees && IsInDegrees(first, second);
    CameraEvent event = EventByName(rows, cells[0]);
    event.written = PlaceOfCells(first, second, columns->order);
    if (IsInDegrees(first, second)) event.position = geo::LatLon{event.written->y, event.written->x};
    event.height_ellipsoid_m = number(3);
    const auto a = number(columns->angles_at);
    const auto b = number(columns->angles_at + 1);
    const auto c = number(columns->angles_at + 2);
    if (a && b && c && columns->angles == Angles::kYawPitchRoll) {
      event.yaw_pitch_roll_rad = Eigen::Vector3d(geo::DegToRad(*a), geo::DegToRad(*b), geo::DegToRad(*c));
    } else if (a && b && c && columns->angles == Angles::kOmegaPhiKappa) {
      event.yaw_pitch_roll_rad = YawPitchRollFromOpk(geo::DegToRad(*a), geo::DegToRad(*b), geo::DegToRad(*c));
    }
    if (columns->accuracy_at > 0) {
      const auto horizontal = number(columns->accuracy_at);
      const auto vertical = number(columns->accuracy_at + 1);
      if (horizontal && vertical && *horizontal > 0.0 && *vertical > 0.0) {
        event.sigma_in_ned_m = Eigen::Vector3d(*horizontal, *horizontal, *vertical);
      }
    }
    ++rows;
    builder.Add(std::move(event));
  }
  if (rows == 0) return Because(ErrorCode::kCorrupt, {RemarkCode::kFileNamesNoPlace, {{"file", name}}});
  builder.Count("row", rows);
  if (columns->angles == Angles::kUnnamed) {
    builder.Warn(RemarkCode::kAnglesWithoutHeader);
  }
  builder.log().written_order_is_named = columns->order.has_value();
  builder.log().written_order_is_assumed = !header.empty() && !columns->order && is_in_degrees;
  builder.log().mapping = {"height -> above the ellipsoid",
                           columns->angles == Angles::kOmegaPhiKappa ? "omega, phi, kappa -> degrees"
                           : columns->angles == Angles::kYawPitchRoll
                               ? "yaw, pitch, roll -> degrees, pitch 0 = straight down"
                               : "no angles"};
  if (bad > 0) builder.Warn({RemarkCode::kRowsUnread, {{"rows", bad}}});
  return std::move(builder).Finish();
}

}  // namespace skyquilt::flight
