#include "core/pipeline/report/odm_exports.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "core/base/text/json_io.h"
#include "core/base/text/plain_text.h"
#include "core/base/text/printable.h"
#include "core/flight/bytes/text_fields.h"
#include "core/flight/logs/log_builder.h"
#include "core/geo/lat_lon.h"
#include "core/poses/conventions/attitude_convention.h"

namespace skyquilt::pipeline {
namespace {

using Json = nlohmann::ordered_json;

// OpenSfM measures in widths of the longer side, from the middle of the picture.
Json BrownModel(const camera::Intrinsics& lens) {
  const double size_px = std::max(lens.width_px, lens.height_px);
  return {{"projection_type", "brown"},
          {"width", lens.width_px},
          {"height", lens.height_px},
          {"focal_x", lens.focal_x_px / size_px},
          {"focal_y", lens.focal_y_px / size_px},
          {"c_x", (lens.center_x_px - 0.5 * (lens.width_px - 1)) / size_px},
          {"c_y", (lens.center_y_px - 0.5 * (lens.height_px - 1)) / size_px},
          {"k1", lens.k1},
          {"k2", lens.k2},
          {"p1", lens.p1},
          {"p2", lens.p2},
          {"k3", lens.k3}};
}

std::string CameraId(const flight::Photo& photo) {
  const camera::Intrinsics& lens = photo.intrinsics;
  return flight::LowerCase(fmt::format("v2 {} {} {} {} brown {:.4f}", photo.make, photo.model, lens.width_px,
                                       lens.height_px,
                                       lens.focal_x_px / std::max(lens.width_px, lens.height_px)));
}

// Of the airframe that a down-looking camera would be fixed to: zero where gimbal angles turn singular.
Eigen::Vector3d AirframeAngles(const Eigen::Quaterniond& cam_from_enu) {
  return flight::YawPitchRollFromNed(poses::EnuFromNed().conjugate() * cam_from_enu.conjugate() *
                                     poses::CamFromBody());
}

constexpr std::string_view kGeoTxtHead = "EPSG:4326\n", kUnnamedPhotos = "# Not here, for this file ";

// A photo's name, position and angles, with or without its accuracy, to the digits of OdmGeoTxt.
bool IsGeoTxtRow(std::string_view line) {
  constexpr std::array kDecimals = {10, 10, 4, 6, 6, 6, 4, 4};
  std::size_t numbers = 0;
  for (std::size_t blank = line.find(' '); blank != std::string_view::npos; ++numbers) {
    const std::size_t end = line.find(' ', blank + 1);
    const std::string_view number = line.substr(blank + 1, end - blank - 1);
    if (numbers == kDecimals.size() || flight::DecimalPlaces(number) != kDecimals[numbers] ||
        !ParseNumber<double>(number))
      return false;
    blank = end;
  }
  return numbers == kDecimals.size() || numbers == kDecimals.size() - 2;
}

}  // namespace

std::string OdmCamerasJson(const alignment::AlignedFlight& flight) {
  std::map<std::string, const alignment::AlignedPhoto*> photo_of_camera;
  for (const alignment::AlignedPhoto& photo : flight.photos)
    photo_of_camera.emplace(photo.photo.camera_key, &photo);
  Json cameras = Json::object();
  for (const auto& [key, photo] : photo_of_camera) {
    // "all" fits whatever name OpenSfM gives a flight's only camera.
    cameras[photo_of_camera.size() == 1 ? "all" : CameraId(photo->photo)] = BrownModel(photo->intrinsics);
  }
  return JsonText(cameras, 2) + "\n";
}

std::string OdmGeoTxt(const alignment::AlignedFlight& flight, double raised_m, alignment::ErrorsKnown known) {
  std::string text(kGeoTxtHead);
  std::size_t unnamed = 0;
  for (const alignment::AlignedPhoto& photo : flight.photos) {
    if (photo.photo.name.find_first_of(" \t\r\n") != std::string::npos) {
      ++unnamed;
      continue;
    }
    const geo::Wgs84 center = flight.frame.Wgs84FromEnu(photo.cam_from_enu.TargetOriginInSource());
    const Eigen::Vector3d deg = AirframeAngles(photo.cam_from_enu.rotation) * (180.0 / geo::kPi);
    text += fmt::format("{} {:.10f} {:.10f} {:.4f} {:.6f} {:.6f} {:.6f}", photo.photo.name, center.lon_deg,
                        center.lat_deg, center.height_ellipsoid_m + raised_m, deg.x(), deg.y(), deg.z());
    if (const std::optional<double> error_m = alignment::KnownErrorM(photo, known))
      text += fmt::format(" {0:.4f} {0:.4f}", std::max(0.01, *error_m));
    text += '\n';
  }
  // Comments at the end: above the rows they could pass for names of columns.
  if (raised_m != 0.0) text += "# Heights count as those of the surveyed points that place the map.\n";
  if (unnamed > 0) {
    text += fmt::format("{}cannot hold the blanks in their names: {}\n", kUnnamedPhotos,
                        Counted(unnamed, "photo"));
  }
  return text;
}

bool IsOdmGeoTxt(std::string_view text) {
  if (!text.starts_with(kGeoTxtHead) || !text.ends_with('\n')) return false;
  bool says_anything = false;
  for (text.remove_prefix(kGeoTxtHead.size()); !text.empty();) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(line.size() + 1);
    const bool is_comment = line.starts_with("# ");
    if (!is_comment && !IsGeoTxtRow(line)) return false;
    says_anything = says_anything || !is_comment || line.starts_with(kUnnamedPhotos);
  }
  return says_anything;
}

}  // namespace skyquilt::pipeline
