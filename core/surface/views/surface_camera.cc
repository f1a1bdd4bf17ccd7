#include "core/surface/views/surface_camera.h"

#include <algorithm>
#include <cmath>

namespace skyquilt::surface {
namespace {

constexpr double kDegree = 0.017453292519943295;
constexpr double kMinHeightM = 1.0;
// Between any two photos of a tile; the second where the first leaves fewer than three.
constexpr double kWantedAngleRad[] = {8.0 * kDegree, 5.0 * kDegree, 3.0 * kDegree};
constexpr double kWidestAngleRad = 40.0 * kDegree;  // from the first: beyond, sides of things look different
constexpr double kPartlySeenRad = 20.0 * kDegree;   // what a photo that shows half of the tile stands back
constexpr std::size_t kEnoughViews = 3;

struct Candidate {
  std::size_t camera = 0;
  double rank = 0.0;
  Eigen::Vector3d towards = Eigen::Vector3d::UnitZ();  // unit, from the tile to the camera
};

// The share of nine places of the box that the photo shows.
double ShareSeen(const SurfaceCamera& camera, const SeenBox& box) {
  int seen = 0;
  for (int i = 0; i < 9; ++i) {
    const int column = i % 3, row = i / 3;
    const double u = 0.5 * column, v = 0.5 * row;
    const double z_m = 0.5 * (box.low_z_m + box.high_z_m);
    const Eigen::Vector3d point(box.in_enu.min.x() + u * box.in_enu.Width(),
                                box.in_enu.min.y() + v * box.in_enu.Height(), z_m);
    if (camera.Sees(point)) ++seen;
  }
  return seen / 9.0;
}

double AngleBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

}  // namespace

bool SurfaceCamera::Sees(const Eigen::Vector3d& point_in_enu) const {
  const Eigen::Vector3d offset = center_in_enu - point_in_enu;
  if (offset.z() <= kMinHeightM || offset.head<2>().norm() > offset.z() * widest_tangent) return false;
  const auto pixel = camera::ProjectRolling(lens, cam_from_enu, motion, point_in_enu);
  return pixel && lens.IsInImage(*pixel);
}

std::vector<SurfaceCamera> SurfaceCameras(const alignment::AlignedFlight& flight,
                                          const ground::GroundSurface& ground, double low_m, double high_m) {
  std::vector<SurfaceCamera> cameras;
  for (std::size_t i = 0; i < flight.photos.size(); ++i) {
    const alignment::AlignedPhoto& photo = flight.photos[i];
    if (photo.placement != alignment::Placement::kAligned) continue;
    SurfaceCamera camera;
    camera.photo = i;
    camera.lens = photo.intrinsics;
    camera.cam_from_enu = photo.cam_from_enu;
    camera.motion = photo.readout_motion;
    camera.rotation = photo.cam_from_enu.rotation.toRotationMatrix();
    camera.center_in_enu = photo.cam_from_enu.TargetOriginInSource();
    camera.widest_tangent = std::tan(photo.max_look_rad);
    camera.height_above_ground_m = std::max(kMinHeightM, photo.height_above_ground_m);
    for (const double z_m : {ground.MinHeight() - low_m, ground.MaxHeight() + high_m}) {
      camera.seen_in_enu.Include(camera::BoundsOf(camera::GroundFootprint(
          photo.intrinsics, photo.cam_from_enu, std::min(z_m, camera.center_in_enu.z() - kMinHeightM), 4,
          photo.max_look_rad)));
    }
    if (!camera.seen_in_enu.IsEmpty()) cameras.push_back(std::move(camera));
  }
  return cameras;
}

ChosenViews ChooseViews(const std::vector<SurfaceCamera>& cameras, const std::vector<std::size_t>& among,
                        const SeenBox& box, int most) {
  const Eigen::Vector2d middle = 0.5 * (box.in_enu.min + box.in_enu.max);
  const Eigen::Vector3d center(middle.x(), middle.y(), 0.5 * (box.low_z_m + box.high_z_m));
  std::vector<Candidate> candidates;
  for (const std::size_t index : among) {
    const SurfaceCamera& camera = cameras[index];
    if (!camera.seen_in_enu.Intersects(box.in_enu)) continue;
    const double share = ShareSeen(camera, box);
    if (share <= 0.0) continue;
    const Eigen::Vector3d towards = (camera.center_in_enu - center).normalized();
    const double off_vertical = std::atan2(towards.head<2>().norm(), towards.z());
    candidates.push_back({index, off_vertical + 2.0 * (1.0 - share) * kPartlySeenRad, towards});
  }
  std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    return a.rank != b.rank ? a.rank < b.rank : a.camera < b.camera;
  });
  std::vector<const Candidate*> chosen;
  for (const double apart_rad : kWantedAngleRad) {
    for (const Candidate& candidate : candidates) {
      if (chosen.size() == static_cast<std::size_t>(most)) break;
      const bool fits =
          std::all_of(chosen.begin(), chosen.end(),
                      [&](const Candidate* other) {
                        return AngleBetween(other->towards, candidate.towards) >= apart_rad;
                      }) &&
          (chosen.empty() || AngleBetween(chosen[0]->towards, candidate.towards) <= kWidestAngleRad);
      if (fits) chosen.push_back(&candidate);
    }
    if (chosen.size() >= kEnoughViews) break;
  }
  ChosenViews views;
  for (const Candidate* candidate : chosen) {
    views.cameras.push_back(candidate->camera);
    for (const Candidate* other : chosen) {
      const Eigen::Vector2d base = candidate->towards.head<2>() / std::max(0.1, candidate->towards.z()) -
                                   other->towards.head<2>() / std::max(0.1, other->towards.z());
      views.widest_base = std::max(views.widest_base, base.norm());
    }
  }
  return views;
}

}  // namespace skyquilt::surface
