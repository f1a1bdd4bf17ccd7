#include "core/ground/footprint_on_ground.h"

#include "core/camera/footprint.h"

namespace skyquilt::ground {

std::vector<Eigen::Vector2d> FootprintOnGround(const GroundSurface& ground,
                                               const camera::Intrinsics& intrinsics,
                                               const geo::Rigid3& cam_from_enu, int points_per_side) {
  constexpr int kSteps = 16;
  const double plane_z_m = ground.MeanHeight();
  std::vector<Eigen::Vector2d> polygon =
      camera::GroundFootprint(intrinsics, cam_from_enu, plane_z_m, points_per_side);
  if (ground.IsPlane()) return polygon;
  const Eigen::Vector3d center = cam_from_enu.TargetOriginInSource();
  for (Eigen::Vector2d& point : polygon) {
    const Eigen::Vector2d per_metre_down = (point - center.head<2>()) / (center.z() - plane_z_m);
    for (int step = 0; step < kSteps; ++step) {
      point = center.head<2>() + per_metre_down * (center.z() - ground.HeightAt(point));
    }
  }
  return polygon;
}

}  // namespace skyquilt::ground
