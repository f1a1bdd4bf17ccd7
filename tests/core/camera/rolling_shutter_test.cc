#include "core/camera/rolling_shutter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "core/camera/sensor_database.h"
#include "tests/support/value_of.h"

namespace skyquilt::camera {
namespace {

// Looks down, tilted; image top to the north.
geo::Rigid3 Pose() {
  const Eigen::Quaterniond down(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()));
  const Eigen::Quaterniond tilt(Eigen::AngleAxisd(0.2, Eigen::Vector3d(1.0, 2.0, 0.3).normalized()));
  return geo::Rigid3::FromRotationAndTargetOrigin(tilt * down, {3.0, -4.0, 60.0});
}

Intrinsics Lens() {
  Intrinsics lens = Intrinsics::Centered(800, 600, 620.0);
  lens.k1 = -0.1;
  return lens;
}

TEST(RollingShutter, SeesAPointFromWhereTheCameraWasWhileItsRowWasRead) {
  const Eigen::Vector3d motion_m(1.2, -0.7, 0.2);
  for (double east_m = -20.0; east_m <= 20.0; east_m += 10.0) {
    for (double north_m = -20.0; north_m <= 20.0; north_m += 10.0) {
      const Eigen::Vector3d point(east_m, north_m, 1.5);
      const auto seen = test::ValueOf(ProjectRolling(Lens(), Pose(), {motion_m, {}}, point));
      // The camera at that row's moment, moved by hand.
      const double share = (seen.y() + 0.5) / 600.0 - 0.5;
      const geo::Rigid3 there = geo::Rigid3::FromRotationAndTargetOrigin(
          Pose().rotation, Pose().TargetOriginInSource() + share * motion_m);
      EXPECT_LT((seen - test::ValueOf(Lens().Project(there * point))).norm(), 1e-3);
      EXPECT_LT((PoseAtRow(Pose(), {motion_m, {}}, seen.y(), 600).TargetOriginInSource() -
                 there.TargetOriginInSource())
                    .norm(),
                1e-9);
    }
  }
}

TEST(RollingShutter, StretchesThePictureOfACameraThatFliesTowardsItsTop) {
  const geo::Rigid3 level = geo::Rigid3::FromRotationAndTargetOrigin(
      Eigen::Quaterniond(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX())), {0.0, 0.0, 60.0});
  const Eigen::Vector3d north_m(0.0, 1.0, 0.0), point(0.0, 15.0, 0.0);
  const double still_px = ProjectRolling(Lens(), level, {}, point)->y();
  EXPECT_EQ(still_px, Lens().Project(level * point)->y());
  // In the upper half the camera has not come so far north yet: the point lies farther ahead of it.
  EXPECT_LT(ProjectRolling(Lens(), level, {north_m, {}}, point)->y(), still_px - 1.0);
  EXPECT_GT(ProjectRolling(Lens(), level, {-north_m, {}}, point)->y(), still_px + 1.0);
}

TEST(RollingShutter, SeesNothingBehindTheCamera) {
  EXPECT_FALSE(ProjectRolling(Lens(), Pose(), {{1.0, 0.0, 0.0}, {}}, {0.0, 0.0, 100.0}));
}

TEST(RollingShutter, SeesAPointThroughTheCameraAsItIsTurnedAtItsRow) {
  const RowMotion motion{{1.2, -0.7, 0.2}, {{0.03, -0.04, 0.06}, {0.0, 0.0, 0.0}, {-0.05, 0.02, 0.01}}};
  double most_px = 0.0;  // that it matters
  for (double east_m = -20.0; east_m <= 20.0; east_m += 10.0) {
    for (double north_m = -20.0; north_m <= 20.0; north_m += 10.0) {
      const Eigen::Vector3d point(east_m, north_m, 1.5);
      const auto seen = test::ValueOf(ProjectRolling(Lens(), Pose(), motion, point));
      const double share = (seen.y() + 0.5) / 600.0 - 0.5;
      const double held = std::clamp(share, -0.5, 0.5);  // no gyro tells of rows beyond the picture
      const Eigen::Vector3d turn_rad = held < 0.0 ? Eigen::Vector3d(-2.0 * held * motion.turns_rad.front())
                                                  : Eigen::Vector3d(2.0 * held * motion.turns_rad.back());
      const geo::Rigid3 there = geo::Rigid3::FromRotationAndTargetOrigin(
          geo::RotationFromVector(turn_rad) * Pose().rotation,
          Pose().TargetOriginInSource() + share * motion.shift_in_enu_m);
      EXPECT_LT((seen - test::ValueOf(Lens().Project(there * point))).norm(), 0.01);
      most_px = std::max(most_px, (seen - *Lens().Project(Pose() * point)).norm());
    }
  }
  EXPECT_GT(most_px, 5.0);
}

TEST(RollingShutter, SeesNothingWhereTheCameraTurnsFasterThanItsRows) {
  const RowMotion motion{Eigen::Vector3d::Zero(), {{1.5, 0.0, 0.0}, {0.0, 0.0, 0.0}, {-1.5, 0.0, 0.0}}};
  EXPECT_FALSE(ProjectRolling(Lens(), Pose(), motion, {5.0, 20.0, 0.0}));
}

TEST(FindReadoutS, KnowsCamerasWithAndWithout) {
  EXPECT_DOUBLE_EQ(FindReadoutS("fc330", 12.0).value(), 0.033);
  EXPECT_DOUBLE_EQ(FindReadoutS("fc330", 48.0).value(), 0.033);
  EXPECT_DOUBLE_EQ(FindReadoutS("PHANTOM VISION FC200", 14.0).value(), 0.074);
  EXPECT_DOUBLE_EQ(FindReadoutS("FC3582", 12.2).value(), 0.026);
  EXPECT_DOUBLE_EQ(FindReadoutS("FC3582", 48.8).value(), 0.060);  // four pixels are not joined to one
  EXPECT_FALSE(FindReadoutS("FC6310", 20.0));                     // a mechanical shutter
  EXPECT_FALSE(FindReadoutS("nobody's", 12.0));
}

}  // namespace
}  // namespace skyquilt::camera
