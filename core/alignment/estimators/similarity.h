// Similarity3: turn, scale and shift of space, target = scale * rotation * source + shift, and its robust fit
// to pairs of places of which many may be wrong. A direction known in both frames stands in for what places
// on a line leave open. Pure; any thread.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "core/geo/rigid3.h"

namespace skyquilt::alignment {

struct Similarity3 {
  double scale = 1.0;
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();

  Eigen::Vector3d operator*(const Eigen::Vector3d& point_in_source) const {
    return scale * (rotation * point_in_source) + shift;
  }
  // The pose in the target of a camera posed in the source.
  geo::Rigid3 Moved(const geo::Rigid3& cam_from_source) const;
};

struct PlacePair {
  Eigen::Vector3d in_source = Eigen::Vector3d::Zero();
  Eigen::Vector3d in_target = Eigen::Vector3d::Zero();
  // Of the place in the target; infinite where it says nothing of the height.
  Eigen::Vector3d sigma = Eigen::Vector3d::Ones();
};

// The source direction that points along the target's +z, give or take.
struct UpDirection {
  Eigen::Vector3d in_source = Eigen::Vector3d::UnitZ();
  double sigma_rad = 0.1;
};

struct FittedSimilarity {
  Similarity3 target_from_source;
  std::vector<bool> holds;  // by pair
  int held = 0;
  double median_residual = 0.0;  // horizontal, of those that hold
  double spread_sigmas = 1.0;    // RMS residual in sigmas, at least 1
};

// Least squares (S. Umeyama, PAMI 1991) of three or more pairs that are all right.
std::optional<Similarity3> FitSimilarity3(const std::vector<PlacePair>& pairs);

// At least two pairs with `up`, three without; nothing when fewer than half of the pairs agree on any, or
// whose median residual exceeds a share of the places' own spread. Deterministic.
std::optional<FittedSimilarity> FitRobustly(const std::vector<PlacePair>& pairs,
                                            const std::optional<UpDirection>& up,
                                            double max_residual_share = 0.25);

}  // namespace skyquilt::alignment
