#include "core/pipeline/report/locate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/camera/footprint.h"

namespace skyquilt::pipeline {
namespace {

const LocatedCamera* FindCamera(const LocatedMap& map, std::string_view photo) {
  for (const LocatedCamera& camera : map.cameras) {
    if (camera.name == photo) return &camera;
  }
  return nullptr;
}

double QualityOf(const std::optional<double>& sharpness, double off_nadir_rad) {
  constexpr double kSharp = 0.8;
  const double vertical = std::cos(off_nadir_rad);
  return std::clamp(sharpness.value_or(1.0) / kSharp, 0.0, 1.0) * vertical * vertical;
}

// A placement error moves the point by its radius across the ray, and by more where the ray meets the ground
// slantingly.
double SigmaUnder(double error_radius_m, double off_nadir_rad) {
  return error_radius_m / std::cos(off_nadir_rad);
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
  return map.frame.Wgs84FromEnu(GroundInEnu(map, position));
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

}  // namespace skyquilt::pipeline
