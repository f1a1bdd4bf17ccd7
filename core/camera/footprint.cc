#include "core/camera/footprint.h"

#include <algorithm>
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

namespace {

double AngleOffVertical(const Eigen::Vector3d& ray_in_enu) {
  return std::atan2(ray_in_enu.head<2>().norm(), -ray_in_enu.z());
}

// The ground point of a ray, pulled in to the widest view angle allowed when it goes beyond.
Eigen::Vector2d GroundOfRay(const Eigen::Vector3d& ray_in_enu, const Eigen::Vector3d& center, double drop_m,
                            double max_angle_rad) {
  const Eigen::Vector2d sideways = ray_in_enu.head<2>();
  const double length = sideways.norm();
  if (length < 1e-12) return center.head<2>();
  const double reach_m = drop_m * std::tan(std::min(AngleOffVertical(ray_in_enu), max_angle_rad));
  return center.head<2>() + (reach_m / length) * sideways;
}

}  // namespace

std::vector<Eigen::Vector2d> GroundFootprint(const Intrinsics& intrinsics, const geo::Rigid3& cam_from_enu,
                                             double plane_z_m, int points_per_side, double max_angle_rad) {
  const Eigen::Vector3d center = cam_from_enu.TargetOriginInSource();
  const double drop_m = center.z() - plane_z_m;
  if (drop_m <= 0.0) return {};
  // The lower part of a photo with the horizon in it looks at the ground, whatever its axis does.
  bool sees_ground =
      AngleOffVertical(cam_from_enu.rotation.conjugate() * Eigen::Vector3d::UnitZ()) <= max_angle_rad;
  const double right = intrinsics.width_px - 0.5;
  const double bottom = intrinsics.height_px - 0.5;
  const Eigen::Vector2d corners[4] = {{-0.5, -0.5}, {right, -0.5}, {right, bottom}, {-0.5, bottom}};
  std::vector<Eigen::Vector2d> polygon;
  polygon.reserve(4 * static_cast<std::size_t>(points_per_side));
  for (int side = 0; side < 4; ++side) {
    for (int i = 0; i < points_per_side; ++i) {
      const double t = static_cast<double>(i) / points_per_side;
      const Eigen::Vector2d pixel = (1.0 - t) * corners[side] + t * corners[(side + 1) % 4];
      const Eigen::Vector3d ray = cam_from_enu.rotation.conjugate() * intrinsics.Unproject(pixel);
      sees_ground = sees_ground || AngleOffVertical(ray) <= max_angle_rad;
      polygon.push_back(GroundOfRay(ray, center, drop_m, max_angle_rad));
    }
  }
  if (!sees_ground) return {};
  std::reverse(polygon.begin(), polygon.end());  // the image runs clockwise as seen from above
  return polygon;
}

geo::Bounds2 BoundsOf(const std::vector<Eigen::Vector2d>& polygon) {
  geo::Bounds2 bounds;
  for (const Eigen::Vector2d& point : polygon) bounds.Include(point);
  return bounds;
}

double AreaM2(const std::vector<Eigen::Vector2d>& polygon) {
  double twice = 0.0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d& a = polygon[i];
    const Eigen::Vector2d& b = polygon[(i + 1) % polygon.size()];
    twice += a.x() * b.y() - b.x() * a.y();
  }
  return 0.5 * std::abs(twice);
}

bool PolygonContains(const std::vector<Eigen::Vector2d>& polygon, const Eigen::Vector2d& point) {
  bool inside = false;
  for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    const Eigen::Vector2d& a = polygon[i];
    const Eigen::Vector2d& b = polygon[j];
    if ((a.y() > point.y()) != (b.y() > point.y()) &&
        point.x() < (b.x() - a.x()) * (point.y() - a.y()) / (b.y() - a.y()) + a.x()) {
      inside = !inside;
    }
  }
  return inside;
}

}  // namespace skyquilt::camera
