#include "core/camera/rolling_shutter.h"

namespace skyquilt::camera {

geo::Rigid3 PoseAtRow(const geo::Rigid3& cam_from_enu, const Eigen::Vector3d& motion_in_enu_m, double y_px,
                      int height_px) {
  geo::Rigid3 there = cam_from_enu;
  there.translation -= RowShare(y_px, height_px) * (cam_from_enu.rotation * motion_in_enu_m);
  return there;
}

std::optional<Eigen::Vector2d> ProjectRolling(const Intrinsics& lens, const geo::Rigid3& cam_from_enu,
                                              const Eigen::Vector3d& motion_in_enu_m,
                                              const Eigen::Vector3d& point_in_enu) {
  // Which row sees the point depends on where the camera was, and that on the row: each step is nearer by the
  // factor by which the camera is slower than its rows.
  constexpr int kSteps = 3;
  std::optional<Eigen::Vector2d> pixel = lens.Project(cam_from_enu * point_in_enu);
  if (motion_in_enu_m.isZero(0.0)) return pixel;
  for (int step = 0; pixel && step < kSteps; ++step) {
    pixel = lens.Project(PoseAtRow(cam_from_enu, motion_in_enu_m, pixel->y(), lens.height_px) * point_in_enu);
  }
  return pixel;
}

}  // namespace skyquilt::camera
