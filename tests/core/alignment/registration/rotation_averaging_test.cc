#include "core/alignment/estimators/rotation_averaging.h"

#include <gtest/gtest.h>

#include "core/geo/rigid3.h"
#include "tests/core/alignment/registration/uniform.h"

namespace skyquilt::alignment {
namespace {

Eigen::Vector3d Random(Sampler& sampler, double most) {
  return most * Eigen::Vector3d(2.0 * Uniform(sampler) - 1.0, 2.0 * Uniform(sampler) - 1.0,
                                2.0 * Uniform(sampler) - 1.0);
}

// By as many matches as count for the most.
PhotoPair Turned(int first, int second, const Eigen::Quaterniond& second_from_first) {
  PhotoPair pair{first, second, {}, {}};
  pair.matches.resize(100);
  pair.poses.push_back({second_from_first, Eigen::Vector3d::Zero()});
  return pair;
}

TEST(RotationAveraging, FindsTheRotationsAndTheWrongPairs) {
  Sampler sampler(5);
  constexpr int kRotations = 40;
  std::vector<Eigen::Quaterniond> truth;
  for (int i = 0; i < kRotations; ++i) truth.push_back(geo::RotationFromVector(Random(sampler, 2.0)));
  std::vector<PhotoPair> pairs;
  std::vector<char> is_wrong;
  for (int i = 0; i < kRotations; ++i) {
    for (int step = 1; step <= 6; ++step) {
      const int j = (i + step) % kRotations;
      const int first = std::min(i, j), second = std::max(i, j);
      Eigen::Quaterniond second_from_first =
          geo::RotationFromVector(Random(sampler, 0.01)) * truth[second] * truth[first].conjugate();
      const bool wrong = Uniform(sampler) < 0.2;
      if (wrong) second_from_first = geo::RotationFromVector(Random(sampler, 2.0));
      pairs.push_back(Turned(first, second, second_from_first));
      is_wrong.push_back(wrong ? 1 : 0);
    }
  }
  const AveragedRotations averaged = AverageRotations(kRotations, pairs);
  // Up to one turn of everything.
  const Eigen::Quaterniond gauge = averaged.cam_from_world[0].conjugate() * truth[0];
  for (int i = 0; i < kRotations; ++i) {
    EXPECT_LT((averaged.cam_from_world[i] * gauge).angularDistance(truth[i]), 0.02) << i;
  }
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    if (is_wrong[p]) continue;
    EXPECT_LT(averaged.residual_rad[p], 0.05);
  }
  int found = 0, wrong = 0;
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    wrong += is_wrong[p];
    found += is_wrong[p] && averaged.residual_rad[p] > 0.2 ? 1 : 0;
  }
  EXPECT_GE(found, 0.9 * wrong);
}

TEST(RotationAveraging, APhotoWithoutPairsStaysAsItIs) {
  const AveragedRotations averaged = AverageRotations(
      5, {Turned(0, 1, Eigen::Quaterniond::Identity()), Turned(3, 4, Eigen::Quaterniond::Identity())});
  EXPECT_LT(averaged.cam_from_world[2].angularDistance(Eigen::Quaterniond::Identity()), 1e-9);
}

}  // namespace
}  // namespace skyquilt::alignment
