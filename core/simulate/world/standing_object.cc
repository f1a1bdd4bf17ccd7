#include "core/simulate/world/standing_object.h"

#include <algorithm>
#include <utility>

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

namespace {

constexpr double kObjectCellM = 6.0;
constexpr int kMaxCellsASide = 500;
constexpr double kSlackM = 1e-6;  // what lies on a border is found from both sides

geo::Bounds2 BoundsOf(const StandingObject& object) {
  const Eigen::Vector2d reach = Eigen::Vector2d::Constant(object.ReachM() + kSlackM);
  return {object.outline.center_in_enu - reach, object.outline.center_in_enu + reach};
}

}  // namespace

ObjectGrid::ObjectGrid(std::vector<StandingObject> objects) : objects_(std::move(objects)) {
  if (objects_.empty()) return;
  for (const StandingObject& object : objects_) bounds_.Include(BoundsOf(object));
  cell_m_ = std::max({kObjectCellM, bounds_.Width() / kMaxCellsASide, bounds_.Height() / kMaxCellsASide});
  size_ = ((bounds_.max - bounds_.min) / cell_m_).array().floor().cast<int>() + 1;
  cells_.resize(static_cast<std::size_t>(size_.x()) * static_cast<std::size_t>(size_.y()));
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    const geo::Bounds2 reach = BoundsOf(objects_[i]);
    const Eigen::Array2i first = CellAt(reach.min), last = CellAt(reach.max);
    const double highest_m = objects_[i].HighestM() + kSlackM;
    highest_m_ = std::max(highest_m_, highest_m);
    for (int y = first.y(); y <= last.y(); ++y) {
      for (int x = first.x(); x <= last.x(); ++x) {
        Cell& cell = cells_[static_cast<std::size_t>(y) * static_cast<std::size_t>(size_.x()) +
                            static_cast<std::size_t>(x)];
        cell.objects.push_back(static_cast<int>(i));
        cell.highest_m = std::max(cell.highest_m, highest_m);
      }
    }
  }
}

Eigen::Array2i ObjectGrid::CellAt(const Eigen::Vector2d& east_north) const {
  const Eigen::Array2i cell = ((east_north - bounds_.min) / cell_m_).array().floor().cast<int>();
  return cell.max(0).min(size_ - 1);
}

std::optional<ObjectGrid::Top> ObjectGrid::TopAt(const Eigen::Vector2d& east_north) const {
  if (!bounds_.Contains(east_north)) return std::nullopt;
  std::optional<Top> highest;
  for (const int i : At(CellAt(east_north)).objects) {
    const std::optional<double> z_m = objects_[static_cast<std::size_t>(i)].TopAt(east_north);
    if (z_m && (!highest || *z_m > highest->z_m)) highest = Top{i, *z_m};
  }
  return highest;
}

std::optional<ObjectGrid::Hit> ObjectGrid::CastRay(const Eigen::Vector3d& start,
                                                   const Eigen::Vector3d& direction,
                                                   double max_distance_m) const {
  if (objects_.empty() || direction.z() >= 0.0) return std::nullopt;
  // Only the part below the highest top and over the grid can meet one.
  double enter = std::max(0.0, (start.z() - highest_m_) / -direction.z());
  double leave = max_distance_m;
  for (int axis = 0; axis < 2; ++axis) {
    if (std::abs(direction[axis]) < 1e-15) {
      if (start[axis] < bounds_.min[axis] || start[axis] > bounds_.max[axis]) return std::nullopt;
      continue;
    }
    const double a = (bounds_.min[axis] - start[axis]) / direction[axis];
    const double b = (bounds_.max[axis] - start[axis]) / direction[axis];
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  if (enter > leave) return std::nullopt;

  Eigen::Array2i cell = CellAt((start + enter * direction).head<2>());
  Eigen::Array2i step;
  Eigen::Array2d next;  // distance along the ray at which it crosses into the next column, and row
  Eigen::Array2d every;
  for (int axis = 0; axis < 2; ++axis) {
    step[axis] = direction[axis] > 0.0 ? 1 : -1;
    const bool is_along = std::abs(direction[axis]) < 1e-15;
    const double border = bounds_.min[axis] + cell_m_ * (cell[axis] + (step[axis] > 0 ? 1 : 0));
    next[axis] = is_along ? leave : (border - start[axis]) / direction[axis];
    every[axis] = is_along ? leave : cell_m_ / std::abs(direction[axis]);
  }
  std::optional<Hit> nearest;
  while (true) {
    const double cell_end = std::min(next.minCoeff(), leave);
    const Cell& here = At(cell);
    if (start.z() + cell_end * direction.z() <= here.highest_m) {
      for (const int i : here.objects) {
        const std::optional<ObjectHit> hit = objects_[static_cast<std::size_t>(i)].CastRay(start, direction);
        if (!hit || hit->distance_m > max_distance_m) continue;
        if (!nearest || hit->distance_m < nearest->at.distance_m) nearest = Hit{i, *hit};
      }
    }
    if (cell_end >= leave || (nearest && nearest->at.distance_m <= cell_end)) return nearest;
    const int axis = next.x() < next.y() ? 0 : 1;
    cell[axis] += step[axis];
    if (cell[axis] < 0 || cell[axis] >= size_[axis]) return nearest;
    next[axis] += every[axis];
  }
}

}  // namespace skyquilt::simulate
