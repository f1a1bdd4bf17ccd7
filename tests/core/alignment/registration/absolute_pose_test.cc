#include "core/alignment/estimators/absolute_pose.h"

#include <gtest/gtest.h>

#include "tests/core/alignment/registration/uniform.h"

namespace skyquilt::alignment {
namespace {

const geo::Rigid3 kTruth{geo::RotationFromVector({2.9, 0.2, 0.1}), {3.0, -2.0, 45.0}};

std::vector<PointObservation> SightsOf(const camera::Intrinsics& lens, int count, double wrong_share) {
  Sampler sampler(3);
  std::vector<PointObservation> observations;
  while (static_cast<int>(observations.size()) < count) {
    const Eigen::Vector3d point(80.0 * Uniform(sampler) - 40.0, 80.0 * Uniform(sampler) - 40.0,
                                2.0 * Uniform(sampler));
    const auto pixel = lens.Project(kTruth * point);
    if (!pixel || !lens.IsInImage(*pixel)) continue;
    PointObservation observation{*pixel, point, 1.0};
    if (Uniform(sampler) < wrong_share) {
      observation.pixel_in_image = {4000.0 * Uniform(sampler), 3000.0 * Uniform(sampler)};
    }
    observations.push_back(observation);
  }
  return observations;
}

TEST(AbsolutePose, ThreePointsGiveThePoseAmongUpToFour) {
  const camera::Intrinsics lens = camera::Intrinsics::Centered(4000, 3000, 3000.0);
  const std::vector<PointObservation> observations = SightsOf(lens, 3, 0.0);
  std::array<Eigen::Vector3d, 3> rays, points;
  for (std::size_t k = 0; k < 3; ++k) {
    rays[k] = lens.Unproject(observations[k].pixel_in_image).normalized();
    points[k] = observations[k].point_in_world;
  }
  double nearest = 1e9;
  const std::vector<geo::Rigid3> poses = PosesOfThree(rays, points);
  EXPECT_LE(poses.size(), 4U);
  for (const geo::Rigid3& pose : poses) {
    nearest = std::min(nearest, pose.rotation.angularDistance(kTruth.rotation) +
                                    (pose.translation - kTruth.translation).norm());
  }
  EXPECT_LT(nearest, 1e-5);
}

TEST(AbsolutePose, TwoThirdsWrongSightsDoNotMoveIt) {
  camera::Intrinsics lens = camera::Intrinsics::Centered(4000, 3000, 3000.0);
  lens.k1 = -0.08;
  const auto found = FindPose(lens, SightsOf(lens, 150, 0.65), 1, {});
  ASSERT_TRUE(found);
  EXPECT_LT(found->cam_from_world.rotation.angularDistance(kTruth.rotation), 1e-4);
  EXPECT_LT((found->cam_from_world.translation - kTruth.translation).norm(), 0.01);
  EXPECT_GT(found->inliers.size(), 40U);
}

TEST(AbsolutePose, NoPoseIsFoundWhereSightsAreChance) {
  const camera::Intrinsics lens = camera::Intrinsics::Centered(4000, 3000, 3000.0);
  EXPECT_FALSE(FindPose(lens, SightsOf(lens, 100, 1.0), 1, {}));
}

}  // namespace
}  // namespace skyquilt::alignment
