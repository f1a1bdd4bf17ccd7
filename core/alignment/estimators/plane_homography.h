// FitHomography: the projective map of one plane onto another that brings pairs of places nearest together:
// the direct linear transform on normalised coordinates (Hartley, In defense of the eight-point algorithm,
// 1997; eq. 2 of Iz and Unel). RobustHomography finds it among wrong pairs by OpenCV's MAGSAC (Barath and
// others, CVPR 2019), with a fixed seed: the same pairs give the same map. Pure; any thread.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace skyquilt::alignment {

struct PlanePair {
  Eigen::Vector2d from = Eigen::Vector2d::Zero();
  Eigen::Vector2d to = Eigen::Vector2d::Zero();
};

struct RobustFit {
  Eigen::Matrix3d to_from = Eigen::Matrix3d::Identity();
  std::vector<int> inliers;  // indices of the pairs that agree
};

// Where the map takes a place; nothing for places that it sends beyond the horizon.
std::optional<Eigen::Vector2d> MapPlace(const Eigen::Matrix3d& to_from, const Eigen::Vector2d& from);

// Nothing for fewer than four pairs or pairs on one line.
std::optional<Eigen::Matrix3d> FitHomography(const std::vector<PlanePair>& pairs);

// `tolerance`: in units of `to`. Believed by the rule of Brown and Lowe (Automatic Panoramic Image Stitching,
// 2007): more inliers than 5.9 and 0.22 of the pairs.
std::optional<RobustFit> RobustHomography(const std::vector<PlanePair>& pairs, double tolerance,
                                          int max_trials = 1000);

}  // namespace skyquilt::alignment
