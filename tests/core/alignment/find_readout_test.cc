#include "core/alignment/bundle/find_readout.h"

#include <Eigen/Geometry>
#include <memory>
#include <random>

#include "core/alignment/bundle/reprojection_cost.h"
#include "tests/core/alignment/cost_derivatives.h"

namespace skyquilt::alignment {
namespace {

constexpr double kCameraHeightM = 60.0;
constexpr double kReadoutS = 0.05;
const Eigen::Vector3d kEastwards(8.0, 0.0, 0.0);

// Nine photos straight down, three lines of three flown eastwards, their tops turned by `turn_rad` each
// against the one before; seen while the camera flew on for `readout_s`, to a third of a pixel.
BundleProblem NinePhotos(double readout_s, double turn_rad) {
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0.0, 0.3);
  BundleProblem problem;
  BundleLens lens;
  lens.recorded = lens.intrinsics = camera::Intrinsics::Centered(2000, 1500, 1400.0);
  problem.lenses.push_back(lens);
  const Eigen::Quaterniond down(Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()));
  for (int i = 0; i < 9; ++i) {
    BundlePhoto photo;
    const Eigen::Quaterniond turned(Eigen::AngleAxisd(i * turn_rad, Eigen::Vector3d::UnitZ()));
    photo.cam_from_enu = photo.prior_cam_from_enu = geo::Rigid3::FromRotationAndTargetOrigin(
        turned * down, {14.0 * (i % 3), 14.0 * (i / 3), kCameraHeightM});
    photo.sigma_position_m = Eigen::Vector3d::Constant(0.5);
    photo.height_above_ground_m = kCameraHeightM;
    photo.velocity_in_enu_mps = kEastwards;
    problem.photos.push_back(photo);
  }
  const camera::RowMotion motion{.shift_in_enu_m = readout_s * kEastwards, .turns_rad = {}};
  for (int east = -20; east <= 48; east += 4) {
    for (int north = -20; north <= 48; north += 4) {
      Track track;
      track.point_in_enu = {1.0 * east, 1.0 * north, 2.0 * std::sin(0.2 * east + 0.1 * north)};
      for (int i = 0; i < 9; ++i) {
        const auto seen =
            camera::ProjectRolling(lens.recorded, problem.photos[i].cam_from_enu, motion, track.point_in_enu);
        if (!seen || seen->x() < 0.0 || seen->x() > 1999.0 || seen->y() < 0.0 || seen->y() > 1499.0) continue;
        track.observations.push_back({i, *seen + Eigen::Vector2d(noise(random), noise(random)), 0.3});
      }
      if (track.observations.size() >= 2) problem.tracks.push_back(track);
    }
  }
  return problem;
}

const PhotoSet kAnyMayRoll(9, true);

TEST(FindReadout, IsFoundWherePhotosAreTurnedAgainstTheirCourse) {
  BundleProblem still = NinePhotos(kReadoutS, 0.9);
  AdjustBundle(still, {});
  EXPECT_EQ(LensesThatMayRoll(still, kAnyMayRoll), std::vector<int>{0});
  EXPECT_TRUE(LensesThatMayRoll(still, PhotoSet(9)).empty());

  BundleProblem rolling = NinePhotos(kReadoutS, 0.9);
  rolling.lenses[0].finds_readout = true;
  AdjustBundle(rolling, {});
  EXPECT_NEAR(rolling.lenses[0].readout_s, kReadoutS, 0.05 * kReadoutS);
  for (const BundlePhoto& photo : rolling.photos) {
    EXPECT_LT((photo.readout_motion.shift_in_enu_m - rolling.lenses[0].readout_s * kEastwards).norm(), 1e-9);
  }
  EXPECT_EQ(LensesThatRoll(rolling, {0}), std::vector<int>{0});
}

TEST(FindReadout, IsNotFoundOfACameraThatExposesAllRowsAtOnce) {
  BundleProblem problem = NinePhotos(0.0, 0.9);
  AdjustBundle(problem, {});
  EXPECT_TRUE(LensesThatMayRoll(problem, kAnyMayRoll).empty());
  problem.lenses[0].finds_readout = true;  // asked for all the same
  AdjustBundle(problem, {});
  EXPECT_NEAR(problem.lenses[0].readout_s, 0.0, 0.002);
  EXPECT_TRUE(LensesThatRoll(problem, {0}).empty());
}

// Stretched alike, the photos fit each other; only surveyed places could tell.
TEST(FindReadout, IsNotGuessedWhereAllPhotosAreTakenAlike) {
  BundleProblem problem = NinePhotos(kReadoutS, 0.0);
  AdjustBundle(problem, {});
  EXPECT_TRUE(LensesThatMayRoll(problem, kAnyMayRoll).empty());
}

TEST(FindReadout, DoesWithoutObservationsAndWithoutVelocities) {
  BundleProblem problem = NinePhotos(kReadoutS, 0.9);
  for (BundlePhoto& photo : problem.photos) photo.velocity_in_enu_mps.reset();
  EXPECT_TRUE(LensesThatMayRoll(problem, kAnyMayRoll).empty());
  problem.lenses[0].finds_readout = true;
  AdjustBundle(problem, {});
  EXPECT_EQ(problem.lenses[0].readout_s, 0.0);
  EXPECT_TRUE(LensesThatRoll(problem, {0}).empty());
  problem.tracks.clear();
  EXPECT_TRUE(LensesThatMayRoll(problem, kAnyMayRoll).empty());
  EXPECT_TRUE(LensesThatRoll(problem, {0}).empty());
}

TEST(RollingReprojectionCost, ChangesAsItsDerivativesSay) {
  const geo::Rigid3 start = geo::Rigid3::FromRotationAndTargetOrigin(
      Eigen::Quaterniond(Eigen::AngleAxisd(3.0, Eigen::Vector3d(1.0, 0.2, 0.1).normalized())),
      {4.0, -3.0, 60.0});
  const std::unique_ptr<ceres::CostFunction> cost(
      MakeRollingReprojectionCost(StartOf(start, {.shift_in_enu_m = {0.3, 0.1, 0.0}, .turns_rad = {}},
                                          camera::Intrinsics::Centered(2000, 1500, 1400.0)),
                                  {9.0, 4.0, 0.5}, {1200.0, 300.0}, 0.7));
  ExpectOwnDerivatives(*cost, {{0.02, -0.05, 0.3, 0.5, -0.4, 0.8},
                               {10.0, 6.0, 2.0},
                               {0.01, 3.0, -2.0, -0.1, 0.05, 0.001, -0.002},
                               {0.04}});
}

}  // namespace
}  // namespace skyquilt::alignment
