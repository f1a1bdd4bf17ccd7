#include "core/pipeline/surface/choose_ground.h"

#include <cmath>
#include <cstddef>
#include <vector>

#include "core/surface/views/surface_camera.h"

namespace skyquilt::pipeline {
namespace {

constexpr double kLeansPx = 2.0;
constexpr std::size_t kMaxPointsAsked = 5000;  // that are looked at, evenly from all
constexpr int kPlacesAcross = 40;              // of the ground, each way

double LeanPx(const Eigen::Vector3d& point_in_enu, double ground_m,
              const std::vector<surface::SurfaceCamera>& cameras) {
  const surface::SurfaceCamera* nearest = nullptr;
  double nearest_m = 0.0;
  for (const surface::SurfaceCamera& camera : cameras) {
    const double aside_m = (camera.center_in_enu - point_in_enu).head<2>().norm();
    if ((nearest != nullptr && aside_m >= nearest_m) || !camera.Sees(point_in_enu)) continue;
    nearest = &camera;
    nearest_m = aside_m;
  }
  if (nearest == nullptr) return 0.0;
  const double over_m = nearest->center_in_enu.z() - point_in_enu.z();
  if (!(over_m > 0.0)) return 0.0;
  const double lean_m = std::abs(point_in_enu.z() - ground_m) * nearest_m / over_m;
  return nearest->CellInPhotoPx(lean_m);
}

double LeaningShare(const alignment::AlignedFlight& flight, const ground::GroundSurface& ground,
                    const std::vector<surface::SurfaceCamera>& cameras) {
  const std::vector<Eigen::Vector3d>& points = flight.tie_points_in_enu;
  if (points.empty()) return 0.0;
  const std::size_t step = (points.size() + kMaxPointsAsked - 1) / kMaxPointsAsked;
  std::size_t looked_at = 0, leaning = 0;
  for (std::size_t i = 0; i < points.size(); i += step, ++looked_at) {
    if (LeanPx(points[i], ground.HeightAt(points[i].head<2>()), cameras) > kLeansPx) ++leaning;
  }
  return static_cast<double>(leaning) / static_cast<double>(looked_at);
}

double SeenShare(const ground::GroundSurface& ground, const std::vector<surface::SurfaceCamera>& cameras) {
  geo::Bounds2 all;
  for (const surface::SurfaceCamera& camera : cameras) all.Include(camera.seen_in_enu);
  if (all.IsEmpty()) return 0.0;
  int shown = 0, borne_out = 0;
  for (int row = 0; row < kPlacesAcross; ++row) {
    for (int column = 0; column < kPlacesAcross; ++column) {
      const Eigen::Vector2d at(all.min.x() + (column + 0.5) / kPlacesAcross * all.Width(),
                               all.min.y() + (row + 0.5) / kPlacesAcross * all.Height());
      const Eigen::Vector3d place(at.x(), at.y(), ground.HeightAt(at));
      int photos = 0;
      for (std::size_t i = 0; i < cameras.size() && photos < kPhotosThatBearOut; ++i)
        photos += cameras[i].seen_in_enu.Contains(at) && cameras[i].Sees(place) ? 1 : 0;
      shown += photos > 0 ? 1 : 0;
      borne_out += photos >= kPhotosThatBearOut ? 1 : 0;
    }
  }
  return shown == 0 ? 0.0 : static_cast<double>(borne_out) / shown;
}

}  // namespace

GroundChoice ChooseGround(const alignment::AlignedFlight& flight, const ground::GroundSurface& ground) {
  const std::vector<surface::SurfaceCamera> cameras = surface::SurfaceCameras(flight, ground, 0.0, 0.0);
  return {LeaningShare(flight, ground, cameras), SeenShare(ground, cameras)};
}

}  // namespace skyquilt::pipeline
