// FindPose: where a photo was taken, from points whose place is known and the pixels that see them, many of
// them wrong: three points at a time (J. Grunert 1841, as R. Haralick and others, IJCV 1994, give it), the
// pose with most inliers, refined. Deterministic by the seed. Frame `world`. Pure; any thread.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/alignment/scene/matches.h"
#include "core/camera/intrinsics.h"
#include "core/geo/rigid3.h"

namespace skyquilt::alignment {

struct PointObservation {
  Eigen::Vector2d pixel_in_image;
  Eigen::Vector3d point_in_world;
  double sigma_px = 1.0;
};

struct FoundPose {
  geo::Rigid3 cam_from_world;
  std::vector<int> inliers;  // observations
  // Where many are looked for: the number of the photo, and the pairs by which it hangs on others.
  int photo = 0;
  std::vector<PhotoPair> links = {};
};

struct FindPoseOptions {
  int min_inliers = 12;
  int max_samples = 200;
};

// Up to four poses that see three points along three rays (unit vectors in cam).
std::vector<geo::Rigid3> PosesOfThree(const std::array<Eigen::Vector3d, 3>& rays,
                                      const std::array<Eigen::Vector3d, 3>& points);

// The pose brought nearer to the observations `used`: damped Gauss-Newton with Cauchy's weight at 2.5 sigmas,
// ten steps at most. Needs a start that has most of the points before the camera; where no step helps, the
// start comes back.
geo::Rigid3 RefineResection(const camera::Intrinsics& lens, const geo::Rigid3& start,
                            const std::vector<PointObservation>& observations, const std::vector<int>& used);

std::optional<FoundPose> FindPose(const camera::Intrinsics& lens,
                                  const std::vector<PointObservation>& observations, std::uint64_t seed,
                                  const FindPoseOptions& options);

}  // namespace skyquilt::alignment
