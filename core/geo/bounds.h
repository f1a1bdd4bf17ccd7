// Axis-aligned bounds in the plane of whatever frame the name of the variable says. Values; any thread.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <limits>

namespace skyquilt::geo {

struct Bounds2 {
  Eigen::Vector2d min = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector2d max = Eigen::Vector2d::Constant(-std::numeric_limits<double>::infinity());

  bool IsEmpty() const { return !(min.x() <= max.x() && min.y() <= max.y()); }
  double Width() const { return max.x() - min.x(); }
  double Height() const { return max.y() - min.y(); }
  void Include(const Eigen::Vector2d& point) {
    min = min.cwiseMin(point);
    max = max.cwiseMax(point);
  }
  void Include(const Bounds2& other) {
    min = min.cwiseMin(other.min);
    max = max.cwiseMax(other.max);
  }
  bool Contains(const Eigen::Vector2d& point) const {
    return point.x() >= min.x() && point.x() <= max.x() && point.y() >= min.y() && point.y() <= max.y();
  }
  bool Intersects(const Bounds2& other) const {
    return min.x() <= other.max.x() && other.min.x() <= max.x() && min.y() <= other.max.y() &&
           other.min.y() <= max.y();
  }
};

}  // namespace skyquilt::geo
