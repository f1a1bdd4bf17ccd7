#include "core/geo/rigid3.h"

#include <gtest/gtest.h>

#include <random>

namespace skyquilt::geo {
namespace {

Rigid3 RandomRigid(std::mt19937& random) {
  std::normal_distribution<double> normal;
  const Eigen::Quaterniond rotation(normal(random), normal(random), normal(random), normal(random));
  return {rotation.normalized(), 100.0 * Eigen::Vector3d(normal(random), normal(random), normal(random))};
}

TEST(Rigid3, ComposesAndInvertsLikeTheMotionsItStandsFor) {
  std::mt19937 random(1);
  for (int i = 0; i < 200; ++i) {
    const Rigid3 a_from_b = RandomRigid(random);
    const Rigid3 b_from_c = RandomRigid(random);
    const Eigen::Vector3d point = RandomRigid(random).translation;
    EXPECT_LT(((a_from_b * b_from_c) * point - a_from_b * (b_from_c * point)).norm(), 1e-9);
    EXPECT_LT((a_from_b.Inverse() * (a_from_b * point) - point).norm(), 1e-9);
    EXPECT_LT((a_from_b * a_from_b.TargetOriginInSource()).norm(), 1e-9);
    const Rigid3 again =
        Rigid3::FromRotationAndTargetOrigin(a_from_b.rotation, a_from_b.TargetOriginInSource());
    EXPECT_LT((again * point - a_from_b * point).norm(), 1e-9);
  }
}

TEST(RotationVector, RoundTripsFromTinyToHalfATurn) {
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  for (const double angle : {0.0, 1e-12, 1e-7, 1e-3, 1.0, 3.1}) {
    const Eigen::Vector3d omega =
        angle * Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized();
    EXPECT_LT((VectorFromRotation(RotationFromVector(omega)) - omega).norm(), 1e-12 + 1e-9 * angle) << angle;
  }
}

}  // namespace
}  // namespace skyquilt::geo
