// RayIntersection: the point nearest to all of several rays (least squares of the distances across). A value;
// one thread.
#pragma once

#include <Eigen/Core>

#include "core/geo/solvers/dense_solvers.h"

namespace skyquilt::alignment {

class RayIntersection {
 public:
  // `ray`: of length 1, from `center` on.
  void Add(const Eigen::Vector3d& center, const Eigen::Vector3d& ray) {
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - ray * ray.transpose();
    normal_ += across;
    right_ += across * center;
  }
  // Of two rays or more that are not parallel.
  Eigen::Vector3d Point() const { return geo::SolveSymmetric(normal_, right_); }

 private:
  Eigen::Matrix3d normal_ = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right_ = Eigen::Vector3d::Zero();
};

}  // namespace skyquilt::alignment
