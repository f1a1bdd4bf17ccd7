#include "core/simulate/world/standing_object.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace skyquilt::simulate {
namespace {

std::optional<double> EnterEllipsoid(const Ellipsoid& ellipsoid, const Eigen::Vector3d& start,
                                     const Eigen::Vector3d& direction) {
  const Eigen::Array3d half(ellipsoid.half_width_m, ellipsoid.half_width_m, ellipsoid.half_height_m);
  const Eigen::Vector3d from = (start - ellipsoid.center_in_enu).array() / half;
  const Eigen::Vector3d along = direction.array() / half;
  const double a = along.squaredNorm();
  const double b = from.dot(along);
  const double root = b * b - a * (from.squaredNorm() - 1.0);
  if (root < 0.0) return std::nullopt;
  const double distance_m = (-b - std::sqrt(root)) / a;
  return distance_m > 0.0 ? std::optional(distance_m) : std::nullopt;
}

}  // namespace

Eigen::Vector3d StandingObject::RoofPointAt(const Eigen::Vector2d& at) const {
  const Eigen::Vector2d& axis = outline.axis_in_enu;
  const Eigen::Vector2d place =
      outline.center_in_enu + at.x() * axis + at.y() * Eigen::Vector2d(-axis.y(), axis.x());
  return {place.x(), place.y(), RoofHeightAt(at)};
}

std::array<Eigen::Vector3d, 4> StandingObject::Corners() const {
  const double x = outline.half_size_m.x(), y = outline.half_size_m.y();
  return {RoofPointAt({-x, -y}), RoofPointAt({x, -y}), RoofPointAt({x, y}), RoofPointAt({-x, y})};
}

std::optional<double> StandingObject::TopAt(const Eigen::Vector2d& east_north) const {
  if (kind != ObjectKind::kTree) {
    const Eigen::Vector2d at = outline.ToAxes(east_north);
    if (std::abs(at.x()) > outline.half_size_m.x() || std::abs(at.y()) > outline.half_size_m.y())
      return std::nullopt;
    return RoofHeightAt(at);
  }
  std::optional<double> top;
  for (const Ellipsoid& part : crown) {
    const double from_axis = (east_north - part.center_in_enu.head<2>()).norm() / part.half_width_m;
    if (from_axis > 1.0) continue;
    const double height_m =
        part.center_in_enu.z() + part.half_height_m * std::sqrt(1.0 - from_axis * from_axis);
    if (!top || height_m > *top) top = height_m;
  }
  return top;
}

std::optional<ObjectHit> StandingObject::CastRay(const Eigen::Vector3d& start,
                                                 const Eigen::Vector3d& direction) const {
  if (kind == ObjectKind::kTree) {
    std::optional<ObjectHit> nearest;
    for (const Ellipsoid& part : crown) {
      const std::optional<double> distance_m = EnterEllipsoid(part, start, direction);
      if (distance_m && (!nearest || *distance_m < nearest->distance_m)) nearest = ObjectHit{*distance_m};
    }
    return nearest;
  }
  // Convex: the part of the ray that lies within four sides and below both planes of the roof.
  const Eigen::Vector2d from = outline.ToAxes(start.head<2>());
  const Eigen::Vector2d along = outline.ToAxes(outline.center_in_enu + direction.head<2>());
  const Eigen::Vector2d& half = outline.half_size_m;
  const double over = start.z() - ridge_m - rise_per_m * from.x();
  const double climbs = direction.z() - rise_per_m * along.x();
  const struct {
    double outside, outwards;  // the start's distance beyond the plane, and how that grows along the ray
  } planes[] = {{from.x() - half.x(), along.x()},
                {-from.x() - half.x(), -along.x()},
                {from.y() - half.y(), along.y()},
                {-from.y() - half.y(), -along.y()},
                {over + fall_per_m * from.y(), climbs + fall_per_m * along.y()},
                {over - fall_per_m * from.y(), climbs - fall_per_m * along.y()}};
  double enter = 0.0;
  double leave = std::numeric_limits<double>::infinity();
  int entered_by = -1;
  for (int i = 0; i < 6; ++i) {
    const auto& plane = planes[i];
    if (std::abs(plane.outwards) < 1e-15) {
      if (plane.outside > 0.0) return std::nullopt;
      continue;
    }
    const double t = -plane.outside / plane.outwards;
    if (plane.outwards > 0.0) {
      leave = std::min(leave, t);
    } else if (t > enter) {
      enter = t;
      entered_by = i;
    }
  }
  if (enter > leave || entered_by < 0) return std::nullopt;
  return ObjectHit{enter, entered_by < 4};
}

}  // namespace skyquilt::simulate
