#include "core/alignment/scene/view.h"

#include <cmath>

namespace skyquilt::alignment {
namespace {

constexpr double kFlattestRay = 0.2;  // sine of the least angle below the horizon that is still of use

bool MeetAlong(const Eigen::Vector3d& center, const Eigen::Vector3d& ray, const Relief& relief,
               Eigen::Vector3d* point) {
  if (ray.z() > -kFlattestRay * ray.norm()) return false;
  double z = relief.MeanHeight();
  for (int i = 0; i < (relief.IsFlat() ? 1 : 4); ++i) {
    const double reach = (z - center.z()) / ray.z();
    if (reach <= 0.0) return false;
    *point = center + reach * ray;
    z = relief.HeightAt(point->head<2>());
  }
  return true;
}

}  // namespace

Eigen::Vector2d AxisOnGround(const Eigen::Quaterniond& enu_from_cam, const Eigen::Vector3d& center,
                             double ground_z_m) {
  const Eigen::Vector3d axis = enu_from_cam * Eigen::Vector3d::UnitZ();
  if (axis.z() > -0.2) return center.head<2>();
  return (center + (ground_z_m - center.z()) / axis.z() * axis).head<2>();
}

bool MeetGround(const View& view, const Relief& relief, const Eigen::Vector2d& pixel_in_image,
                Eigen::Vector3d* point_in_enu) {
  const geo::Rigid3 cam_from_enu = view.CamFromEnuAt(pixel_in_image);
  const Eigen::Vector3d ray = cam_from_enu.rotation.conjugate() * view.intrinsics.Unproject(pixel_in_image);
  return MeetAlong(cam_from_enu.TargetOriginInSource(), ray, relief, point_in_enu);
}

std::vector<GroundKeypoint> ProjectToGround(const PhotoFeatures& features, const View& view,
                                            const Relief& relief) {
  std::vector<GroundKeypoint> projected(features.keypoints.size());
  const bool moves = !view.readout_motion.IsStill();
  Eigen::Vector3d center = view.CenterInEnu();
  Eigen::Quaterniond enu_from_cam = view.cam_from_enu.rotation.conjugate();
  for (std::size_t i = 0; i < projected.size(); ++i) {
    const Keypoint& keypoint = features.keypoints[i];
    if (moves) {
      const geo::Rigid3 there = view.CamFromEnuAt({keypoint.x_px, keypoint.y_px});
      center = there.TargetOriginInSource();
      enu_from_cam = there.rotation.conjugate();
    }
    const Eigen::Vector3d ray_in_cam = view.intrinsics.Unproject({keypoint.x_px, keypoint.y_px});
    Eigen::Vector3d point;
    if (!MeetAlong(center, enu_from_cam * ray_in_cam, relief, &point)) continue;
    // The same step in the image, as a ray beside the first; the lens bends both alike.
    const double reach = keypoint.scale_px / view.intrinsics.focal_x_px;
    const Eigen::Vector3d beside_in_cam =
        ray_in_cam +
        Eigen::Vector3d(reach * std::cos(keypoint.angle_rad), reach * std::sin(keypoint.angle_rad), 0.0);
    const Eigen::Vector3d beside_ray = enu_from_cam * beside_in_cam;
    if (beside_ray.z() > -0.05) continue;
    const Eigen::Vector3d beside = center + ((point.z() - center.z()) / beside_ray.z()) * beside_ray;
    const Eigen::Vector2d step = (beside - point).head<2>();
    projected[i].place = {point.x(), point.y()};
    projected[i].angle_rad = static_cast<float>(std::atan2(step.y(), step.x()));
    projected[i].log2_scale = static_cast<float>(std::log2(std::max(1e-6, step.norm())));
    projected[i].is_on_ground = true;
  }
  return projected;
}

}  // namespace skyquilt::alignment
