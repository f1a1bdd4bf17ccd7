#include "core/alignment/estimators/epipolar.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <numeric>

#include "tests/core/alignment/registration/uniform.h"

namespace skyquilt::alignment {
namespace {

geo::Rigid3 TruePose() {
  geo::Rigid3 pose;
  pose.rotation = geo::RotationFromVector({0.05, -0.1, 0.8});
  pose.translation = Eigen::Vector3d(0.9, 0.2, 0.15).normalized();
  return pose;
}

// Points five to seven deep, or on a plane that leans.
std::vector<RayPair> PairsOf(const geo::Rigid3& pose, int count, bool is_flat, double noise = 0.0) {
  Sampler sampler(7);
  std::vector<RayPair> pairs;
  for (int k = 0; k < count; ++k) {
    Eigen::Vector3d point(4.0 * Uniform(sampler) - 2.0, 3.0 * Uniform(sampler) - 1.5, 0.0);
    point.z() = is_flat ? 6.0 + 0.1 * point.x() + 0.05 * point.y() : 5.0 + 2.0 * Uniform(sampler);
    const Eigen::Vector3d other = pose.rotation * point + pose.translation;
    const Eigen::Vector2d off(noise * (Uniform(sampler) - 0.5), noise * (Uniform(sampler) - 0.5));
    pairs.push_back({point.head<2>() / point.z(), other.head<2>() / other.z() + off});
  }
  return pairs;
}

std::vector<int> All(const std::vector<RayPair>& pairs) {
  std::vector<int> all(pairs.size());
  std::iota(all.begin(), all.end(), 0);
  return all;
}

TEST(Epipolar, FivePairsInReliefGiveTheEssentialMatrix) {
  const geo::Rigid3 truth = TruePose();
  const std::vector<RayPair> pairs = PairsOf(truth, 5, false);
  const Eigen::Matrix3d expected = EssentialOfPose(truth).normalized();
  double nearest = 1.0;
  for (const Eigen::Matrix3d& found : EssentialsOfFive({pairs[0], pairs[1], pairs[2], pairs[3], pairs[4]})) {
    nearest = std::min({nearest, (found - expected).norm(), (found + expected).norm()});
  }
  EXPECT_LT(nearest, 1e-6);
}

TEST(Epipolar, TheEssentialMatrixGivesThePoseWithPointsInFront) {
  const geo::Rigid3 truth = TruePose();
  const std::vector<RayPair> pairs = PairsOf(truth, 40, false);
  const geo::Rigid3 found = PoseOfEssential(EssentialOfPose(truth), pairs, All(pairs));
  EXPECT_LT(found.rotation.angularDistance(truth.rotation), 1e-6);
  EXPECT_GT(found.translation.dot(truth.translation), 1.0 - 1e-9);
}

TEST(Epipolar, AHomographyOfAPlaneGivesThePoseAmongFew) {
  const geo::Rigid3 truth = TruePose();
  const std::vector<RayPair> pairs = PairsOf(truth, 30, true);
  const std::optional<Eigen::Matrix3d> homography = FitHomography(pairs, All(pairs));
  ASSERT_TRUE(homography);
  for (const RayPair& pair : pairs) EXPECT_LT(TransferError2(*homography, pair), 1e-16);
  const std::vector<geo::Rigid3> poses = PosesOfHomography(*homography, pairs, All(pairs));
  ASSERT_FALSE(poses.empty());
  EXPECT_LE(poses.size(), 2U);
  double nearest = 10.0;
  for (const geo::Rigid3& pose : poses) {
    nearest = std::min(nearest, pose.rotation.angularDistance(truth.rotation) +
                                    (pose.translation - truth.translation).norm());
  }
  EXPECT_LT(nearest, 1e-5);
}

TEST(Epipolar, ThreePointsOnALineGiveNoHomography) {
  const std::vector<RayPair> pairs{{{0, 0}, {0, 0}}, {{1, 1}, {1, 1}}, {{2, 2}, {2, 2}}, {{3, 3}, {3, 3}}};
  EXPECT_FALSE(FitHomography(pairs, All(pairs)));
}

TEST(Epipolar, RefiningBringsAPoseThatIsDegreesOffToTheTruth) {
  const geo::Rigid3 truth = TruePose();
  const std::vector<RayPair> pairs = PairsOf(truth, 200, false, 1e-4);
  geo::Rigid3 start;
  start.rotation = geo::RotationFromVector({0.03, 0.02, -0.02}) * truth.rotation;
  start.translation = (truth.translation + Eigen::Vector3d(0.05, -0.1, 0.05)).normalized();
  const geo::Rigid3 found = RefinePose(start, pairs, All(pairs), 0.01, 20);
  EXPECT_LT(found.rotation.angularDistance(truth.rotation), 1e-3);
  EXPECT_LT((found.translation - truth.translation).norm(), 5e-3);
}

TEST(Epipolar, DepthsAreThoseOfThePoint) {
  const geo::Rigid3 truth = TruePose();
  const Eigen::Vector3d point(0.5, -0.3, 6.0);
  const Eigen::Vector3d other = truth.rotation * point + truth.translation;
  const auto depths = Depths(truth, {point.head<2>() / point.z(), other.head<2>() / other.z()});
  ASSERT_TRUE(depths);
  EXPECT_NEAR(depths->x(), 6.0, 1e-9);
  EXPECT_NEAR(depths->y(), other.z(), 1e-9);
}

}  // namespace
}  // namespace skyquilt::alignment
