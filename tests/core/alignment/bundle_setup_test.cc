// What positions are believed after an adjustment showed how far they miss.
#include "core/alignment/from_records/bundle_setup.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <utility>

namespace skyquilt::alignment {
namespace {

// Of each photo: what its position claims and by how much it is missed, both of each axis.
BundleProblem Missed(const std::vector<std::pair<double, double>>& claimed_and_missed_m) {
  BundleProblem problem;
  Track& track = problem.tracks.emplace_back();
  for (const auto& [claimed_m, missed_m] : claimed_and_missed_m) {
    BundlePhoto& photo = problem.photos.emplace_back();
    photo.sigma_position_m.setConstant(claimed_m);
    photo.cam_from_enu = geo::Rigid3::FromRotationAndTargetOrigin(Eigen::Quaterniond::Identity(),
                                                                  Eigen::Vector3d::Constant(missed_m));
    track.observations.push_back({static_cast<int>(problem.photos.size()) - 1, Eigen::Vector2d::Zero(), 1.0});
  }
  return problem;
}

TEST(ReweighPositions, BelievesFalseClaimsLikeAPlainReceiver) {
  BundleProblem problem = Missed(std::vector<std::pair<double, double>>(8, {0.02, 0.3}));
  EXPECT_TRUE(ReweighPositions(problem));
  EXPECT_DOUBLE_EQ(problem.photos[3].sigma_position_m.x(), 1.5);
  EXPECT_FALSE(ReweighPositions(problem)) << "0.3 m of 1.5 m";
  EXPECT_DOUBLE_EQ(problem.photos[3].sigma_position_m.x(), 1.8 * 0.3);
}

TEST(ReweighPositions, HoldsTheErrorsOfPoorPositionsAgainstNoGoodOne) {
  std::vector<std::pair<double, double>> most_are_poor(8, {1.5, 1.2});
  for (std::size_t i = 0; i < 3; ++i) most_are_poor[i] = {0.02, 0.02};
  BundleProblem problem = Missed(most_are_poor);
  EXPECT_FALSE(ReweighPositions(problem));
  EXPECT_DOUBLE_EQ(problem.photos[0].sigma_position_m.x(), 0.02);
  EXPECT_DOUBLE_EQ(problem.photos[7].sigma_position_m.z(), 1.5);
}

TEST(ReweighPositions, TakesPhotosThatStayForNoGoodRecords) {
  std::vector<std::pair<double, double>> two_are_new(10, {1.5, 0.0});
  for (std::size_t i = 8; i < 10; ++i) two_are_new[i] = {1.5, 1.2};
  BundleProblem problem = Missed(two_are_new);
  for (std::size_t i = 0; i < 8; ++i) problem.photos[i].is_fixed = true;
  EXPECT_FALSE(ReweighPositions(problem));
  EXPECT_DOUBLE_EQ(problem.photos[9].sigma_position_m.x(), 1.5) << "two say nothing of each other";
}

}  // namespace
}  // namespace skyquilt::alignment
