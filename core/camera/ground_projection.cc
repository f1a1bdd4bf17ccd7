#include "core/camera/ground_projection.h"

#include <cmath>

namespace skyquilt::camera {

std::optional<Eigen::Vector3d> GroundFromPixel(const Intrinsics& intrinsics, const geo::Rigid3& cam_from_enu,
                                               const Eigen::Vector2d& pixel_in_image, double plane_z_m) {
  const Eigen::Vector3d ray =
      (cam_from_enu.rotation.conjugate() * intrinsics.Unproject(pixel_in_image)).normalized();
  const Eigen::Vector3d center = cam_from_enu.TargetOriginInSource();
  constexpr double kSinHalfDegree = 0.0087;
  const double drop_m = center.z() - plane_z_m;
  if (ray.z() > -kSinHalfDegree || drop_m <= 0.0) return std::nullopt;
  Eigen::Vector3d point = center + (drop_m / -ray.z()) * ray;
  point.z() = plane_z_m;
  return point;
}

std::optional<Eigen::Vector2d> PixelFromEnu(const Intrinsics& intrinsics, const geo::Rigid3& cam_from_enu,
                                            const Eigen::Vector3d& point_in_enu) {
  std::optional<Eigen::Vector2d> pixel = intrinsics.Project(cam_from_enu * point_in_enu);
  if (!pixel || !intrinsics.IsInImage(*pixel)) return std::nullopt;
  return pixel;
}

}  // namespace skyquilt::camera
