#include "core/pipeline/report/locate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/base/text/json_io.h"
#include "core/camera/footprint.h"

namespace skyquilt::pipeline {
namespace {

const LocatedCamera* FindCamera(const LocatedMap& map, std::string_view photo) {
  const auto found = std::ranges::find(map.cameras, photo, &LocatedCamera::name);
  return found == map.cameras.end() ? nullptr : &*found;
}

double QualityOf(const std::optional<double>& sharpness, double off_nadir_rad) {
  constexpr double kSharp = 0.8;
  const double vertical = std::cos(off_nadir_rad);
  return std::clamp(sharpness.value_or(1.0) / kSharp, 0.0, 1.0) * vertical * vertical;
}

// A placement error moves the point by its radius across the ray, by more where this meets ground aslant.
std::optional<double> SigmaUnder(const std::optional<double>& error_radius_m, double off_nadir_rad) {
  if (!error_radius_m) return std::nullopt;
  return *error_radius_m / std::cos(off_nadir_rad);
}

// The first crossing of a ray from above the highest ground, or nothing where it passes over all of it.
std::optional<Eigen::Vector3d> MeetGround(const ground::GroundSurface& ground, const Eigen::Vector3d& center,
                                          const Eigen::Vector3d& direction) {
  const auto point_at_z = [&](double z) -> Eigen::Vector3d {
    return center + direction * ((z - center.z()) / direction.z());
  };
  if (ground.IsPlane()) {
    if (center.z() <= ground.MeanHeight()) return std::nullopt;
    return point_at_z(ground.MeanHeight());
  }
  const auto above = [&](double z) {
    const Eigen::Vector3d point = point_at_z(z);
    return z - ground.HeightAt(point.head<2>());
  };
  // Downwards in steps no longer on the ground than half a cell, then halving.
  double high = std::min(center.z(), ground.MaxHeight() + 1e-6);
  const double low = ground.MinHeight() - 1e-6;
  if (above(high) < 0.0) return std::nullopt;  // the camera stands in the ground
  const double slope = direction.head<2>().norm() / -direction.z();
  const double step = std::max((high - low) / 10'000.0, 0.5 * ground.CellSize() / std::max(slope, 1e-3));
  double below = high;
  while (below > low) {
    below = std::max(low, below - step);
    if (above(below) <= 0.0) break;
    high = below;
  }
  if (above(below) > 0.0) return std::nullopt;
  constexpr int kHalvings = 60;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (high + below);
    (above(middle) > 0.0 ? high : below) = middle;
  }
  return point_at_z(0.5 * (high + below));
}

Eigen::Vector3d GroundInEnu(const LocatedMap& map, const geo::LatLon& position) {
  // The vertical of the position is not quite that of the frame: a few rounds settle the height.
  constexpr int kRounds = 5;
  Eigen::Vector3d point = map.frame.EnuAtHeight(position, map.ground.MeanHeight());
  for (int i = 0; i < kRounds; ++i)
    point = map.frame.EnuAtHeight(position, map.ground.HeightAt(point.head<2>()));
  return point;
}

}  // namespace

Result<GroundPoint> GroundAtPixel(const LocatedMap& map, std::string_view photo,
                                  const Eigen::Vector2d& pixel_in_image) {
  const LocatedCamera* camera = FindCamera(map, photo);
  if (camera == nullptr) {
    return Error{ErrorCode::kNotFound, fmt::format("The map was not made with a photo named \"{}\".", photo),
                 ""};
  }
  const camera::Intrinsics& lens = camera->intrinsics;
  if (!lens.IsInImage(pixel_in_image)) {
    return Error{ErrorCode::kUnprocessable,
                 fmt::format("The pixel lies outside the photo, which is {} x {} pixels.", lens.width_px,
                             lens.height_px),
                 ""};
  }
  const geo::Rigid3 cam_from_enu =
      camera::PoseAtRow(camera->cam_from_enu, camera->readout_motion, pixel_in_image.y(), lens.height_px);
  const Eigen::Vector3d direction =
      (cam_from_enu.rotation.conjugate() * lens.Unproject(pixel_in_image)).normalized();
  const double off_nadir_rad = std::acos(std::clamp(-direction.z(), -1.0, 1.0));
  const Error horizon{ErrorCode::kUnprocessable, "The pixel looks towards the horizon, not at the ground.",
                      ""};
  if (off_nadir_rad > camera::kMaxViewAngleRad) return horizon;
  const std::optional<Eigen::Vector3d> point =
      MeetGround(map.ground, cam_from_enu.TargetOriginInSource(), direction);
  if (!point) return horizon;
  const geo::Wgs84 wgs84 = map.frame.Wgs84FromEnu(*point);
  return GroundPoint{{.lat_deg = wgs84.lat_deg, .lon_deg = wgs84.lon_deg},
                     SigmaUnder(camera->error_radius_m, off_nadir_rad)};
}

geo::Wgs84 GroundAt(const LocatedMap& map, const geo::LatLon& position) {
  geo::Wgs84 on_ground = map.frame.Wgs84FromEnu(GroundInEnu(map, position));
  on_ground.height_ellipsoid_m += map.raised_m;
  return on_ground;
}

std::vector<Sighting> PhotosAtPoint(const LocatedMap& map, const geo::LatLon& position) {
  const Eigen::Vector3d point = GroundInEnu(map, position);
  std::vector<Sighting> sightings;
  for (const LocatedCamera& camera : map.cameras) {
    const std::optional<Eigen::Vector2d> pixel =
        camera::ProjectRolling(camera.intrinsics, camera.cam_from_enu, camera.readout_motion, point);
    if (!pixel || !camera.intrinsics.IsInImage(*pixel)) continue;
    const Eigen::Vector3d up = camera.cam_from_enu.TargetOriginInSource() - point;
    const double off_nadir_rad = std::atan2(up.head<2>().norm(), up.z());
    if (off_nadir_rad > camera::kMaxViewAngleRad) continue;
    sightings.push_back({camera.name, *pixel, off_nadir_rad, camera.placement,
                         SigmaUnder(camera.error_radius_m, off_nadir_rad), camera.sharpness,
                         QualityOf(camera.sharpness, off_nadir_rad)});
  }
  std::sort(sightings.begin(), sightings.end(), [](const Sighting& a, const Sighting& b) {
    return a.quality != b.quality ? a.quality > b.quality : a.photo < b.photo;
  });
  return sightings;
}

namespace {

using Json = nlohmann::ordered_json;

constexpr int kVersion = 1;

Json GroundOf(const ground::GroundSurface& ground) {
  Json json = {{"z_m", ground.MeanHeight()}};
  if (ground.IsPlane()) return json;
  json["south_west_m"] = {ground.SouthWest().x(), ground.SouthWest().y()};
  json["cell_m"] = ground.CellSize();
  json["columns"] = ground.Columns();
  json["rows"] = ground.Rows();
  json["heights_m"] = ground.Heights();
  return json;
}

Json Numbers(const Eigen::Vector3d& vector) { return {vector.x(), vector.y(), vector.z()}; }

Json CameraOf(const alignment::AlignedPhoto& photo, alignment::ErrorsKnown known) {
  const std::optional<double> error_m = alignment::KnownErrorM(photo, known);
  const camera::Intrinsics& lens = photo.intrinsics;
  const Eigen::Quaterniond& rotation = photo.cam_from_enu.rotation;
  Json json = {{"name", photo.photo.name},
               {"size_px", {lens.width_px, lens.height_px}},
               {"focal_px", {lens.focal_x_px, lens.focal_y_px}},
               {"center_px", {lens.center_x_px, lens.center_y_px}},
               {"distortion", {lens.k1, lens.k2, lens.p1, lens.p2, lens.k3}},
               {"rotation_wxyz", {rotation.w(), rotation.x(), rotation.y(), rotation.z()}},
               {"translation_m", Numbers(photo.cam_from_enu.translation)},
               {"placement", alignment::PlacementName(photo.placement)},
               {"error_radius_m", error_m ? Json(*error_m) : Json()}};
  if (photo.sharpness && std::isfinite(*photo.sharpness)) json["sharpness"] = *photo.sharpness;
  const camera::RowMotion& motion = photo.readout_motion;
  if (!motion.shift_in_enu_m.isZero(0.0)) json["readout_shift_m"] = Numbers(motion.shift_in_enu_m);
  for (const Eigen::Vector3d& turn : motion.turns_rad) json["readout_turns_rad"].push_back(Numbers(turn));
  return json;
}

template <int kSize>
Eigen::Matrix<double, kSize, 1> Vector(const Json& json) {
  Eigen::Matrix<double, kSize, 1> vector;
  for (int i = 0; i < kSize; ++i) vector[i] = json.at(static_cast<std::size_t>(i)).get<double>();
  return vector;
}

// The numbers of a list, one after the other.
template <typename... Values>
void Take(const Json& list, Values&... values) {
  std::size_t i = 0;
  (list.at(i++).get_to(values), ...);
}

// Throws Json's own exceptions for what is missing or of another kind; the caller turns them into an error.
LocatedMap MapFrom(const Json& json) {
  LocatedMap map;
  const Json& origin = json.at("origin");
  map.frame = geo::LocalFrame(
      geo::Wgs84{.lat_deg = origin.at(0), .lon_deg = origin.at(1), .height_ellipsoid_m = origin.at(2)});
  map.raised_m = json.value("raised_m", 0.0);
  const Json& ground = json.at("ground");
  if (ground.contains("heights_m")) {
    auto heights_m = ground.at("heights_m").get<std::vector<float>>();
    const int columns = ground.at("columns");
    const int rows = ground.at("rows");
    const double cell_m = ground.at("cell_m");
    const bool fits = columns >= 2 && rows >= 2 && cell_m > 0.0 &&
                      heights_m.size() == static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
    if (!fits) throw std::invalid_argument("the ground grid's size and heights differ");
    map.ground = ground::GroundSurface::Grid(Vector<2>(ground.at("south_west_m")), cell_m, columns, rows,
                                             std::move(heights_m), ground.at("z_m"));
  } else {
    map.ground = ground::GroundSurface::Plane(ground.at("z_m"));
  }
  for (const Json& from : json.at("cameras")) {
    LocatedCamera camera;
    camera.name = from.at("name");
    camera::Intrinsics& lens = camera.intrinsics;
    Take(from.at("size_px"), lens.width_px, lens.height_px);
    Take(from.at("focal_px"), lens.focal_x_px, lens.focal_y_px);
    Take(from.at("center_px"), lens.center_x_px, lens.center_y_px);
    Take(from.at("distortion"), lens.k1, lens.k2, lens.p1, lens.p2, lens.k3);
    Eigen::Quaterniond& rotation = camera.cam_from_enu.rotation;
    Take(from.at("rotation_wxyz"), rotation.w(), rotation.x(), rotation.y(), rotation.z());
    camera.cam_from_enu.translation = Vector<3>(from.at("translation_m"));
    camera.placement = from.at("placement") == alignment::PlacementName(alignment::Placement::kAligned)
                           ? alignment::Placement::kAligned
                           : alignment::Placement::kPoseOnly;
    const Json& radius_m = from.at("error_radius_m");
    if (!radius_m.is_null()) camera.error_radius_m = radius_m.get<double>();
    if (from.contains("sharpness")) camera.sharpness = from.at("sharpness").get<double>();
    if (from.contains("readout_shift_m"))
      camera.readout_motion.shift_in_enu_m = Vector<3>(from.at("readout_shift_m"));
    if (from.contains("readout_turns_rad")) {
      for (const Json& turn : from.at("readout_turns_rad"))
        camera.readout_motion.turns_rad.push_back(Vector<3>(turn));
    }
    map.cameras.push_back(std::move(camera));
  }
  return map;
}

}  // namespace

std::string LocateJson(const alignment::AlignedFlight& flight, const ground::GroundSurface& ground,
                       double raised_m, alignment::ErrorsKnown known) {
  const geo::Wgs84& origin = flight.frame.origin();
  Json cameras = Json::array();
  for (const alignment::AlignedPhoto& photo : flight.photos) cameras.push_back(CameraOf(photo, known));
  Json json;
  json["version"] = kVersion;
  json["origin"] = {origin.lat_deg, origin.lon_deg, origin.height_ellipsoid_m};
  if (raised_m != 0.0) json["raised_m"] = raised_m;
  json["ground"] = GroundOf(ground);
  json["cameras"] = std::move(cameras);
  return JsonText(json) + "\n";
}

Result<LocatedMap> ParseLocateJson(std::string_view text) {
  const Error damaged{ErrorCode::kCorrupt, "The map's camera file is damaged. Stitch the flight again.", ""};
  const Json json = ParseOrderedJson(text);
  if (!json.is_object()) return damaged;
  try {
    if (json.at("version") != kVersion) {
      return Error{ErrorCode::kUnprocessable,
                   "The map's camera file is of another version. Stitch the flight again.", ""};
    }
    return MapFrom(json);
  } catch (const std::exception& failure) {
    return Error{damaged.code, damaged.message, failure.what()};
  }
}

}  // namespace skyquilt::pipeline
