#include "core/simulate/world/object_colors.h"

#include <algorithm>
#include <cmath>

#include "core/simulate/world/ground_colors.h"
#include "core/simulate/world/noise.h"

namespace skyquilt::simulate {
namespace {

constexpr double kStoreyM = 2.8;
constexpr double kNoWindowsM = 50.0;  // up a wall: bricks alone
constexpr double kParapetM = 0.3;

// 1 on level ground.
float LightOn(const Eigen::Vector3d& normal) {
  const Eigen::Vector3d to_sun(-0.45, -0.45, 0.77);
  return static_cast<float>(0.55 + 0.45 / to_sun.z() * std::max(0.0, normal.dot(to_sun)));
}

Eigen::Vector3d FromAxes(const Building& outline, double x, double y, double z) {
  const Eigen::Vector2d& axis = outline.axis_in_enu;
  return Eigen::Vector3d(x * axis.x() - y * axis.y(), x * axis.y() + y * axis.x(), z).normalized();
}

Eigen::Vector3f SideColor(const StandingObject& object, const Eigen::Vector2d& at, double up_m,
                          float footprint_m) {
  const Building& outline = object.outline;
  const bool is_long_side =
      outline.half_size_m.y() - std::abs(at.y()) < outline.half_size_m.x() - std::abs(at.x());
  const Eigen::Vector3d normal = is_long_side ? FromAxes(outline, 0.0, std::copysign(1.0, at.y()), 0.0)
                                              : FromAxes(outline, std::copysign(1.0, at.x()), 0.0, 0.0);
  const double along_m = is_long_side ? at.x() : at.y() + 50.0;
  const double in_storey_m =
      object.IsHouse() ? up_m - kStoreyM * std::floor(up_m / kStoreyM) : kNoWindowsM + up_m;
  return LightOn(normal) * WallColor(along_m, in_storey_m, outline, footprint_m);
}

Eigen::Vector3f GravelColor(const GroundPoint& point, const Building& outline, const Eigen::Vector2d& at) {
  Parcel yard;
  yard.kind = ParcelKind::kFarmyard;
  const Eigen::Vector3f gravel = 1.1f * ParcelColor(point, yard, TextureLevel::kRich);
  const double to_edge_m =
      std::min(outline.half_size_m.x() - std::abs(at.x()), outline.half_size_m.y() - std::abs(at.y()));
  const float parapet = 0.8f * Cover(kParapetM - to_edge_m, point.footprint_m);
  return gravel + parapet * (Eigen::Vector3f(214.0f, 210.0f, 202.0f) - gravel);
}

Eigen::Vector3f CrownColor(const StandingObject& tree, const Eigen::Vector3d& point, float footprint_m) {
  // The part that the point lies on.
  const Ellipsoid* part = nullptr;
  double least_off = 0.0;
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  for (const Ellipsoid& other : tree.crown) {
    const Eigen::Array3d half(other.half_width_m, other.half_width_m, other.half_height_m);
    const Eigen::Array3d from = (point - other.center_in_enu).array() / half;
    const double off = std::abs(from.matrix().norm() - 1.0);
    if (part != nullptr && off >= least_off) continue;
    part = &other;
    least_off = off;
    normal = (from / half).matrix().normalized();
  }
  // Noise of the plane, laid through the height aslant in two ways: one alone would be drawn out to streaks.
  const double up_m = point.z() - tree.ground_m;
  const GroundPoint leaf{point.x() + 0.6 * up_m, point.y() - 0.8 * up_m, footprint_m, tree.outline.hash};
  const GroundPoint twig{point.x() - 0.9 * up_m, point.y() - 0.4 * up_m, footprint_m, ~tree.outline.hash};
  const float texture = 0.7f * (GroundTexture(leaf, 1.2f, 0.9f) + GroundTexture(twig, 1.2f, 0.9f));
  const auto share_up = static_cast<float>(up_m / tree.outline.height_m);
  const float light = LightOn(normal) * (0.65f + 0.35f * std::clamp(share_up, 0.0f, 1.0f));
  if (part == &tree.crown.front())
    return light * Eigen::Vector3f(112.0f, 92.0f, 74.0f) + 14.0f * texture * Eigen::Vector3f::Ones();
  const float dry = Uniform(tree.outline.hash, 3);
  const Eigen::Vector3f green =
      Eigen::Vector3f(58.0f, 98.0f, 44.0f) + dry * Eigen::Vector3f(44.0f, 20.0f, 6.0f);
  return light * green + texture * Eigen::Vector3f(34.0f, 38.0f, 24.0f);
}

}  // namespace

Eigen::Vector3f ObjectColor(const StandingObject& object, const Eigen::Vector3d& point_in_enu, bool is_side,
                            float footprint_m) {
  const Eigen::Vector2d at = object.outline.ToAxes(point_in_enu.head<2>());
  const GroundPoint place{point_in_enu.x(), point_in_enu.y(), footprint_m, object.outline.hash};
  Eigen::Vector3f color;
  if (object.kind == ObjectKind::kTree) {
    color = CrownColor(object, point_in_enu, footprint_m);
  } else if (is_side) {
    color = SideColor(object, at, point_in_enu.z() - object.ground_m, footprint_m);
  } else if (object.kind == ObjectKind::kGabledHouse) {
    const double slope = std::copysign(object.fall_per_m, at.y());
    color = LightOn(FromAxes(object.outline, 0.0, slope, 1.0)) * RoofColor(place, object.outline);
  } else {
    color = GravelColor(place, object.outline, at);
  }
  return color.cwiseMax(0.0f).cwiseMin(255.0f);
}

}  // namespace skyquilt::simulate
