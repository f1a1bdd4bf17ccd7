#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <Eigen/Geometry>
#include <random>

#include "core/alignment/estimators/epipolar.h"

namespace skyquilt::alignment {
namespace {

std::vector<RayPair> PairsOf(const Eigen::Matrix3d& to_from, int right, int wrong) {
  std::mt19937 random(11);
  const auto coordinate = [&] { return static_cast<double>(random() % 4000) - 2000.0; };
  std::vector<RayPair> pairs;
  for (int k = 0; k < right; ++k) {
    const Eigen::Vector2d from(coordinate(), coordinate());
    pairs.push_back({from, (to_from * from.homogeneous()).hnormalized()});
  }
  for (int k = 0; k < wrong; ++k)
    pairs.push_back({{coordinate(), coordinate()}, {coordinate(), coordinate()}});
  return pairs;
}

Eigen::Matrix3d SomeHomography() {
  Eigen::Matrix3d h;
  h << 0.9, -0.4, 300.0, 0.35, 1.1, -120.0, 2e-5, -3e-5, 1.0;
  return h;
}

RC_GTEST_PROP(FitHomography, BringsBackWhatMadeThePairs, ()) {
  const auto small = [] { return *rc::gen::inRange(-300, 301) / 1000.0; };
  Eigen::Matrix3d made;
  made << 1.0 + small(), small(), 1000.0 * small(), small(), 1.0 + small(), 1000.0 * small(), 1e-4 * small(),
      1e-4 * small(), 1.0;
  const auto found = FitHomography(PairsOf(made, 12, 0));
  RC_ASSERT(found.has_value());
  for (const RayPair& pair : PairsOf(made, 12, 0)) {
    RC_ASSERT(TransferError2(*found, pair) < 1e-12);
  }
}

TEST(FitHomography, SaysNothingOfPairsOnOneLine) {
  std::vector<RayPair> pairs;
  for (int k = 0; k < 10; ++k) pairs.push_back({{10.0 * k, 5.0 * k}, {7.0 * k, 2.0 * k}});
  EXPECT_FALSE(FitHomography(pairs));
  EXPECT_FALSE(FitHomography({}));
}

TEST(RobustHomography, FindsTheRightPairsAmongAsManyWrongOnes) {
  const auto fit = RobustHomography(PairsOf(SomeHomography(), 60, 60), 2.0);
  ASSERT_TRUE(fit);
  EXPECT_GE(fit->inliers.size(), 60U);
  EXPECT_LE(fit->inliers.size(), 62U);
  EXPECT_LT((fit->second_from_first - SomeHomography()).norm() / SomeHomography().norm(), 1e-3);
}

TEST(RobustHomography, BelievesNoneOfPairsThatOnlyChanceMade) {
  EXPECT_FALSE(RobustHomography(PairsOf(SomeHomography(), 0, 120), 2.0));
}

}  // namespace
}  // namespace skyquilt::alignment
