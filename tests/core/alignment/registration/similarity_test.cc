#include "core/alignment/estimators/similarity.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/core/alignment/registration/uniform.h"
#include "tests/support/value_of.h"

namespace skyquilt::alignment {
namespace {

Similarity3 Truth() {
  Similarity3 truth;
  truth.scale = 2.5;
  truth.rotation = geo::RotationFromVector({0.3, -1.2, 0.7});
  truth.shift = {100.0, -50.0, 20.0};
  return truth;
}

// Places on a grid, or on a line, in the target; noise of 1 m.
std::vector<PlacePair> Places(int count, bool on_line, double wrong_share, double wrong_m) {
  Sampler sampler(11);
  const Similarity3 truth = Truth();
  std::vector<PlacePair> pairs;
  for (int k = 0; k < count; ++k) {
    const Eigen::Vector3d target(on_line ? 15.0 * k : 15.0 * (k % 8), on_line ? 0.0 : 12.0 * (k / 8), 60.0);
    PlacePair pair;
    pair.in_source = truth.rotation.conjugate() * (target - truth.shift) / truth.scale;
    pair.in_target =
        target + Eigen::Vector3d(Uniform(sampler) - 0.5, Uniform(sampler) - 0.5, Uniform(sampler) - 0.5);
    if (Uniform(sampler) < wrong_share) {
      pair.in_target +=
          wrong_m * Eigen::Vector3d(2.0 * Uniform(sampler) - 1.0, 2.0 * Uniform(sampler) - 1.0, 0.0);
    }
    pair.sigma = {1.0, 1.0, 2.0};
    pairs.push_back(pair);
  }
  return pairs;
}

TEST(Similarity, ThreePlacesThatAreRightGiveItExactly) {
  std::vector<PlacePair> pairs;
  for (const Eigen::Vector3d& source :
       {Eigen::Vector3d(1, 2, 3), Eigen::Vector3d(4, 0, 1), Eigen::Vector3d(0, 5, 2)}) {
    pairs.push_back({source, Truth() * source, Eigen::Vector3d::Ones()});
  }
  const auto found = test::ValueOf(FitSimilarity3(pairs));
  EXPECT_NEAR(found.scale, 2.5, 1e-9);
  EXPECT_LT(found.rotation.angularDistance(Truth().rotation), 1e-9);
  EXPECT_LT((found.shift - Truth().shift).norm(), 1e-7);
}

TEST(Similarity, AThirdOfThePlacesMayBeFiftyMetresOff) {
  const std::vector<PlacePair> pairs = Places(40, false, 0.3, 50.0);
  const UpDirection up{Truth().rotation.conjugate() * Eigen::Vector3d::UnitZ(), 0.05};
  for (const std::optional<UpDirection>& given :
       {std::optional<UpDirection>(), std::optional<UpDirection>(up)}) {
    const auto found = test::ValueOf(FitRobustly(pairs, given));
    EXPECT_NEAR(found.target_from_source.scale, 2.5, 0.03);
    EXPECT_LT(found.target_from_source.rotation.angularDistance(Truth().rotation), 0.04);
    EXPECT_LT(found.median_residual, 0.6);
    EXPECT_LT(found.held, 36);
  }
}

TEST(Similarity, TheVerticalDecidesWhatPlacesOnALineLeaveOpen) {
  const std::vector<PlacePair> pairs = Places(12, true, 0.0, 0.0);
  const UpDirection up{Truth().rotation.conjugate() * Eigen::Vector3d::UnitZ(), 0.05};
  const auto found = test::ValueOf(FitRobustly(pairs, up));
  EXPECT_LT(found.target_from_source.rotation.angularDistance(Truth().rotation), 0.03);
}

TEST(Similarity, PlacesWithoutHeightsAreEnoughWithTheVertical) {
  std::vector<PlacePair> pairs = Places(12, false, 0.0, 0.0);
  for (PlacePair& pair : pairs) {
    pair.in_target.z() = 0.0;
    pair.sigma.z() = std::numeric_limits<double>::infinity();
  }
  const UpDirection up{Truth().rotation.conjugate() * Eigen::Vector3d::UnitZ(), 0.01};
  const auto found = test::ValueOf(FitRobustly(pairs, up));
  EXPECT_NEAR(found.target_from_source.scale, 2.5, 0.05);
  EXPECT_LT(found.median_residual, 0.6);
}

TEST(Similarity, PlacesThatAgreeOnNothingGiveNothing) {
  EXPECT_FALSE(FitRobustly(Places(40, false, 1.0, 500.0), std::nullopt));
  EXPECT_FALSE(FitRobustly(Places(2, false, 0.0, 0.0), std::nullopt));
}

TEST(Similarity, ACameraMovesWithTheSpaceItStandsIn) {
  const geo::Rigid3 camera{geo::RotationFromVector({0.1, 0.2, 3.0}), {1.0, 2.0, 3.0}};
  const Eigen::Vector3d point(4.0, 5.0, 60.0);
  const Similarity3 truth = Truth();
  const Eigen::Vector3d before = camera * point;
  const Eigen::Vector3d after = truth.Moved(camera) * (truth * point);
  EXPECT_LT((after - truth.scale * before).norm(), 1e-9);
}

}  // namespace
}  // namespace skyquilt::alignment
