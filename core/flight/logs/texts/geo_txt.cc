#include "core/flight/logs/texts/geo_txt.h"

#include <fmt/format.h>

#include <cmath>

#include "core/base/try.h"
#include "core/flight/logs/log_builder.h"
#include "core/flight/logs/text_fields.h"
#include "core/flight/logs/texts/srs.h"

namespace skyquilt::flight {
namespace {

constexpr std::uint64_t kMaxRows = 200'000;

bool LooksLikeImageName(std::string_view word) {
  const std::size_t dot = word.rfind('.');
  return dot != std::string_view::npos && word.size() - dot >= 3 && word.size() - dot <= 6 &&
         !ParseNumber(word);
}

}  // namespace

bool LooksLikeGeoTxt(LogBytes head) {
  const std::vector<std::string_view> words = FirstReferencedRow(head);
  return words.size() >= 3 && LooksLikeImageName(words[0]) && ParseNumber(words[1]) && ParseNumber(words[2]);
}

Result<FlightLog> ParseGeoTxt(std::string_view name, LogBytes bytes, const ConsumedUpTo&) {
  LogBuilder builder("geo_txt", name);
  LineReader lines(TextOf(bytes));
  std::string_view line;
  if (!lines.Next(line)) return Error{ErrorCode::kCorrupt, fmt::format("{} is empty.", name), ""};
  SKYQUILT_TRY_ASSIGN(const auto srs, ReferenceSystem::Parse(line));
  std::vector<std::string_view> words;
  std::uint64_t rows = 0;
  std::uint64_t bad = 0;
  // Counted with the bad ones: each may cost a transformation.
  while (rows + bad < kMaxRows && lines.Next(line)) {
    SplitBlanks(line, words);
    if (words.empty() || words[0].front() == '#') continue;
    const auto x = words.size() >= 3 ? ParseNumber(words[1]) : std::nullopt;
    const auto y = words.size() >= 3 ? ParseNumber(words[2]) : std::nullopt;
    if (!x || !y) {
      ++bad;
      continue;
    }
    const auto position = srs.ToLatLon(*x, *y);
    if (!position) {
      ++bad;
      continue;
    }
    const auto number = [&](std::size_t i) {
      return i < words.size() ? ParseNumber(words[i]) : std::nullopt;
    };
    CameraEvent event;
    event.t_s = static_cast<double>(rows);
    event.has_time = false;
    event.image_name = std::string(words[0].substr(0, kMaxNameLength));
    event.position = *position;
    if (const auto z = number(3)) event.height_ellipsoid_m = *z * srs.metres_per_unit();
    const auto yaw = number(4);
    const auto pitch = number(5);
    const auto roll = number(6);
    if (yaw && pitch && roll) {
      event.yaw_pitch_roll_rad =
          Eigen::Vector3d(geo::DegToRad(*yaw), geo::DegToRad(*pitch), geo::DegToRad(*roll));
      event.attitude_kind = AttitudeKind::kAirframe;
    }
    const auto sigma_h = number(7);
    const auto sigma_v = number(8);
    if (sigma_h && *sigma_h > 0.0) {
      event.sigma_in_ned_m =
          Eigen::Vector3d(*sigma_h, *sigma_h, sigma_v && *sigma_v > 0.0 ? *sigma_v : 2.0 * *sigma_h);
    }
    ++rows;
    builder.Add(std::move(event));
  }
  if (rows == 0) {
    return Error{ErrorCode::kCorrupt,
                 fmt::format("{} names no photo with a position; rows are \"image x y z\".", name), ""};
  }
  builder.Count("row", rows);
  if (bad > 0) builder.Warn(fmt::format("{} rows could not be read", bad));
  if (rows + bad == kMaxRows && lines.Next(line))
    builder.Warn(fmt::format("more than {} rows; the rest was left out", kMaxRows));
  builder.log().mapping = {fmt::format("x, y -> {}", srs.name()), "z -> height above the ellipsoid",
                           "yaw, pitch, roll -> degrees, pitch 0 = straight down"};
  if (srs.metres_per_unit() != 1.0) {
    builder.log().mapping.push_back(
        fmt::format("z -> times {} to metres, as x and y", srs.metres_per_unit()));
  }
  return std::move(builder).Finish();
}

Result<std::string> WriteGeoTxt(std::span<const CameraEvent> events) {
  std::string text = "EPSG:4326\n";
  for (const CameraEvent& event : events) {
    if (!event.image_name || event.image_name->empty() || !event.position) continue;
    if (event.image_name->find_first_of(" \t\r\n") != std::string::npos) {
      return Error{
          ErrorCode::kInvalidArgument,
          fmt::format("geo.txt cannot hold the blank in \"{}\"; rename the photo", *event.image_name), ""};
    }
    text += fmt::format("{} {:.10f} {:.10f}", *event.image_name, event.position->lon_deg,
                        event.position->lat_deg);
    const auto height_m = event.height_ellipsoid_m ? event.height_ellipsoid_m : event.height_amsl_m;
    // Later columns need the earlier ones: what is not known is NaN for angles and stops the row for heights.
    if (height_m) {
      text += fmt::format(" {:.4f}", *height_m);
      const bool has_angles = event.yaw_pitch_roll_rad.has_value();
      if (has_angles || event.sigma_in_ned_m) {
        Eigen::Vector3d deg = Eigen::Vector3d::Constant(std::nan(""));
        if (has_angles) {
          deg = *event.yaw_pitch_roll_rad * (180.0 / geo::kPi);
          // A gimbal counts from the horizon, this file from nadir.
          if (event.attitude_kind == AttitudeKind::kGimbal) deg.y() += 90.0;
        }
        text += has_angles ? fmt::format(" {:.6f} {:.6f} {:.6f}", deg.x(), deg.y(), deg.z()) : " NaN NaN NaN";
      }
      if (event.sigma_in_ned_m) {
        text += fmt::format(" {:.4f} {:.4f}", std::max(event.sigma_in_ned_m->x(), event.sigma_in_ned_m->y()),
                            event.sigma_in_ned_m->z());
      }
    }
    text += '\n';
  }
  return text;
}

}  // namespace skyquilt::flight
