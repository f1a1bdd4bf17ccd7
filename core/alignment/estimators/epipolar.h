// The geometry of two calibrated views, on rays (x, y, 1): homographies, essential matrices and the poses
// (second_from_first, the shift of length 1) they stand for. Homographies are of pixels as well. Pure; any
// thread.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "core/alignment/scene/matches.h"
#include "core/geo/rigid3.h"

namespace skyquilt::alignment {

struct RobustFit {
  Eigen::Matrix3d second_from_first = Eigen::Matrix3d::Identity();
  std::vector<int> inliers;  // indices of the pairs that agree
};

// Least squares of four or more pairs, in coordinates of unit spread (R. Hartley, PAMI 1997), of determinant
// 1; nothing where they lie badly.
std::optional<Eigen::Matrix3d> FitHomography(const std::vector<RayPair>& pairs, const std::vector<int>& used);
// The same of all pairs, the last number 1; nothing only of pairs on one line.
std::optional<Eigen::Matrix3d> FitHomography(const std::vector<RayPair>& pairs);
// Found among wrong pairs by OpenCV's MAGSAC (Barath and others, CVPR 2019), with a fixed seed: the same
// pairs give the same map. `tolerance`: in units of `second`. Believed by the rule of Brown and Lowe
// (Automatic Panoramic Image Stitching, 2007): more inliers than 5.9 and 0.22 of the pairs.
std::optional<RobustFit> RobustHomography(const std::vector<RayPair>& pairs, double tolerance,
                                          int max_trials = 1000);
// Of the second ray from the first's image; infinite behind the plane's horizon.
double TransferError2(const Eigen::Matrix3d& second_from_first, const RayPair& pair);

// The poses a homography of a plane may stand for (O. Faugeras and F. Lustman 1988, by singular values): up
// to four, those for which most of the pairs lie before both cameras.
std::vector<geo::Rigid3> PosesOfHomography(const Eigen::Matrix3d& second_from_first,
                                           const std::vector<RayPair>& pairs, const std::vector<int>& used);

// Up to ten matrices through five pairs.
std::vector<Eigen::Matrix3d> EssentialsOfFive(const std::array<RayPair, 5>& pairs);
// The one of its four poses for which most of the pairs lie before both cameras.
geo::Rigid3 PoseOfEssential(const Eigen::Matrix3d& essential, const std::vector<RayPair>& pairs,
                            const std::vector<int>& used);
Eigen::Matrix3d EssentialOfPose(const geo::Rigid3& pose);
// First-order distance of the pair from the epipolar constraint, squared.
double Sampson2(const Eigen::Matrix3d& essential, const RayPair& pair);

// Depths along both rays where they come nearest; nothing where they are parallel.
std::optional<Eigen::Vector2d> Depths(const geo::Rigid3& pose, const RayPair& pair);

// Gauss-Newton on Sampson's distance with a robust weight of the given width; five unknowns.
geo::Rigid3 RefinePose(const geo::Rigid3& start, const std::vector<RayPair>& pairs,
                       const std::vector<int>& used, double width, int steps);

}  // namespace skyquilt::alignment
