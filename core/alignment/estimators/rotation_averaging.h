// AverageRotations: one rotation per photo from relative rotations of pairs, some of which are wrong: from a
// spanning tree of the best supported, then by least absolute deviations, then by reweighted least squares
// (A. Chatterjee and V. Govindu, ICCV 2013). Pairs that the rest contradicts stand out by their residual.
// Pure; any thread.
#pragma once

#include <Eigen/Geometry>
#include <vector>

namespace skyquilt::alignment {

struct RelativeRotation {
  int first = 0, second = 0;
  Eigen::Quaterniond second_from_first = Eigen::Quaterniond::Identity();
  double weight = 1.0;  // how well it is supported
};

struct AveragedRotations {
  std::vector<Eigen::Quaterniond> cam_from_world;  // by photo
  std::vector<int> component;                      // photos tied together; negative: no pair at all
  std::vector<double> residual_rad;                // by pair
};

AveragedRotations AverageRotations(int photos, const std::vector<RelativeRotation>& pairs);

}  // namespace skyquilt::alignment
