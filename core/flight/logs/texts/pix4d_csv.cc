#include "core/flight/logs/texts/pix4d_csv.h"

#include <fmt/format.h>

#include <cmath>

#include "core/flight/logs/log_builder.h"
#include "core/flight/logs/text_fields.h"

namespace skyquilt::flight {
namespace {

enum class Angles { kNone, kUnnamed, kYawPitchRoll, kOmegaPhiKappa };

struct Columns {
  std::size_t angles_at = 0;
  std::size_t accuracy_at = 0;  // 0: none
  Angles angles = Angles::kNone;
};

bool IsImageName(std::string_view cell) {
  const std::string lower = LowerCase(cell);
  for (const std::string_view end : {".jpg", ".jpeg", ".tif", ".tiff", ".png", ".dng"}) {
    if (lower.size() > end.size() && lower.ends_with(end)) return true;
  }
  return false;
}

bool IsRow(const std::vector<std::string_view>& cells) {
  if (cells.size() < 4 || cells.size() > 12 || !IsImageName(cells[0])) return false;
  const auto lat = ParseNumber(cells[1]);
  const auto lon = ParseNumber(cells[2]);
  return lat && lon && std::abs(*lat) <= 90.0 && std::abs(*lon) <= 180.0 && ParseNumber(cells[3]);
}

bool IsHeader(std::string_view line) {
  const std::string lower = LowerCase(line);
  return lower.find("image") != std::string::npos && lower.find("latitude") != std::string::npos;
}

// The header decides what columns five to nine mean; without one their number does.
Columns ColumnsOf(std::string_view header, std::size_t count) {
  Columns columns;
  const std::string lower = LowerCase(header);
  if (header.empty()) {
    if (count >= 7) columns.angles = Angles::kUnnamed;
    columns.angles_at = 4;
    columns.accuracy_at = count >= 9 ? 7 : (count == 6 ? 4 : 0);
    return columns;
  }
  std::vector<std::string_view> cells;
  SplitFields(lower, GuessSeparator(lower), cells);
  for (std::size_t i = 4; i < cells.size(); ++i) {
    if (cells[i].find("yaw") != std::string_view::npos && i + 2 < cells.size())
      columns = {i, columns.accuracy_at, Angles::kYawPitchRoll};
    if (cells[i].find("omega") != std::string_view::npos && i + 2 < cells.size())
      columns = {i, columns.accuracy_at, Angles::kOmegaPhiKappa};
    if (cells[i].find("acc") != std::string_view::npos && columns.accuracy_at == 0) columns.accuracy_at = i;
  }
  return columns;
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
  if (!LooksLikeText(TextOf(head))) return false;
  LineReader lines(TextOf(head));
  std::string_view line;
  std::vector<std::string_view> cells;
  for (int i = 0; i < 8 && lines.Next(line); ++i) {
    if (Trim(line).empty()) continue;
    SplitFields(line, GuessSeparator(line), cells);
    if (IsRow(cells)) return true;
    if (line.front() != '#' && !IsHeader(line)) return false;
  }
  return false;
}

Result<FlightLog> ParsePix4dCsv(std::string_view name, LogBytes bytes, const ConsumedUpTo&) {
  LogBuilder builder("pix4d_csv", name);
  LineReader lines(TextOf(bytes));
  std::string_view line;
  std::string header;
  std::optional<Columns> columns;
  std::vector<std::string_view> cells;
  std::uint64_t rows = 0;
  std::uint64_t bad = 0;
  while (lines.Next(line)) {
    if (Trim(line).empty()) continue;
    SplitFields(line, GuessSeparator(line), cells);
    if (!IsRow(cells)) {
      if (rows == 0 && IsHeader(line))
        header = line;
      else if (line.front() != '#')
        ++bad;
      continue;
    }
    if (!columns) columns = ColumnsOf(header, cells.size());
    const auto number = [&](std::size_t i) {
      return i < cells.size() ? ParseNumber(cells[i]) : std::nullopt;
    };
    CameraEvent event;
    event.t_s = static_cast<double>(rows);
    event.has_time = false;
    event.image_name = std::string(cells[0].substr(0, 512));
    event.position = geo::LatLon{*number(1), *number(2)};
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
  if (rows == 0)
    return Error{ErrorCode::kCorrupt, fmt::format("{} names no photo with a position.", name), ""};
  builder.Count("row", rows);
  if (columns->angles == Angles::kUnnamed) {
    builder.Warn(
        "the angles have no header and are left out: write yaw,pitch,roll or omega,phi,kappa above them");
  }
  builder.log().mapping = {"height -> above the ellipsoid",
                           columns->angles == Angles::kOmegaPhiKappa ? "omega, phi, kappa -> degrees"
                           : columns->angles == Angles::kYawPitchRoll
                               ? "yaw, pitch, roll -> degrees, pitch 0 = straight down"
                               : "no angles"};
  if (bad > 0) builder.Warn(fmt::format("{} rows could not be read", bad));
  return std::move(builder).Finish();
}

}  // namespace skyquilt::flight
