#include "core/simulate/sensors/trajectory.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/geo/lat_lon.h"
#include "core/simulate/world/random.h"
#include "tests/support/value_of.h"

namespace skyquilt::simulate {
namespace {

using geo::DegToRad;

const camera::Intrinsics kLens = camera::Intrinsics::Centered(800, 600, 600.0);

TEST(Gimbal, NadirWithYawZeroHasNorthOnTop) {
  const geo::Rigid3 cam_from_enu = geo::Rigid3::FromRotationAndTargetOrigin(
      CamFromEnuOfGimbal({0.0, DegToRad(-90.0), 0.0}), Eigen::Vector3d(0.0, 0.0, 60.0));
  const auto north = kLens.Project(cam_from_enu * Eigen::Vector3d(0.0, 10.0, 0.0));
  const auto east = kLens.Project(cam_from_enu * Eigen::Vector3d(10.0, 0.0, 0.0));
  ASSERT_TRUE(north && east);
  EXPECT_NEAR(north->x(), kLens.center_x_px, 1e-9);
  EXPECT_NEAR(north->y(), kLens.center_y_px - 100.0, 1e-9);
  EXPECT_NEAR(east->x(), kLens.center_x_px + 100.0, 1e-9);
}

TEST(Gimbal, YawTurnsTheImageTopClockwiseAndPitchLooksUp) {
  const Eigen::Quaterniond east_up = CamFromEnuOfGimbal({DegToRad(90.0), DegToRad(-30.0), 0.0});
  const Eigen::Vector3d axis = east_up.conjugate() * Eigen::Vector3d::UnitZ();
  EXPECT_NEAR(axis.x(), std::cos(DegToRad(30.0)), 1e-12);
  EXPECT_NEAR(axis.y(), 0.0, 1e-12);
  EXPECT_NEAR(axis.z(), -std::sin(DegToRad(30.0)), 1e-12);
}

TEST(Gimbal, AnglesGiveTheirRotationBack) {
  RandomStream random(7, 1);
  for (int i = 0; i < 2000; ++i) {
    const double lean = i % 3 == 0 ? 1e-6 : 1.2;
    const YawPitchRoll gimbal{random.Uniform(-geo::kPi, geo::kPi), -0.5 * geo::kPi + lean * random.Uniform(),
                              random.Uniform(-geo::kPi, geo::kPi)};
    const Eigen::Quaterniond rotation = CamFromEnuOfGimbal(gimbal);
    EXPECT_LT(rotation.angularDistance(CamFromEnuOfGimbal(GimbalOfCamFromEnu(rotation))), 2e-8) << i;
  }
  const Eigen::Quaterniond nadir = CamFromEnuOfGimbal({0.7, -0.5 * geo::kPi, 0.0});
  EXPECT_NEAR(GimbalOfCamFromEnu(nadir).yaw_rad, 0.7, 1e-6);
}

TEST(PlanLawnmower, KeepsTheOverlapsAskedFor) {
  TrajectoryOptions options;
  options.photos = 24;
  options.front_overlap = 0.8;
  options.side_overlap = 0.6;
  options.heading_rad = DegToRad(30.0);
  const auto poses = test::ValueOf(PlanLawnmower(options, kLens));
  ASSERT_EQ(poses.size(), 24u);
  const double along_m = options.height_m * 600.0 / 600.0;
  const double across_m = options.height_m * 800.0 / 600.0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int line_changes = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Eigen::Vector3d center = poses[i].cam_from_enu.TargetOriginInSource();
    sum += center;
    EXPECT_NEAR(center.z(), 60.0, 1e-9);
    if (i == 0) continue;
    const double step_m = (center - poses[i - 1].cam_from_enu.TargetOriginInSource()).norm();
    const bool new_line = poses[i].line != poses[i - 1].line;
    EXPECT_NEAR(step_m, new_line ? 0.4 * across_m : 0.2 * along_m, 1e-9);
    EXPECT_GT(poses[i].t_s, poses[i - 1].t_s);
    line_changes += new_line ? 1 : 0;
  }
  EXPECT_GE(line_changes, 2);
  EXPECT_LT((sum / 24.0).head<2>().norm(), 1e-9) << "a full block lies around its origin";
}

TEST(PlanLawnmower, LeansNoMoreThanAskedAndUsesTheRange) {
  TrajectoryOptions options{.photos = 300, .yaw_rule = YawRule::kAnywhere, .max_tilt_rad = DegToRad(15.0)};
  const auto poses = test::ValueOf(PlanLawnmower(options, kLens));
  double largest = 0.0;
  for (const TruePose& pose : poses) {
    const Eigen::Vector3d axis = pose.cam_from_enu.rotation.conjugate() * Eigen::Vector3d::UnitZ();
    largest = std::max(largest, std::acos(-axis.z()));
  }
  EXPECT_LE(largest, DegToRad(15.0) + 1e-9);
  EXPECT_GT(largest, DegToRad(14.0));
}

TEST(PlanLawnmower, RefusesWhatCannotBeFlown) {
  const auto fails = [](auto change) {
    TrajectoryOptions options;
    change(options);
    const auto poses = PlanLawnmower(options, kLens);
    return !poses.ok() && poses.error().code == ErrorCode::kInvalidArgument && !poses.error().message.empty();
  };
  EXPECT_TRUE(fails([](TrajectoryOptions& o) { o.photos = 0; }));
  EXPECT_TRUE(fails([](TrajectoryOptions& o) { o.height_m = -5.0; }));
  EXPECT_TRUE(fails([](TrajectoryOptions& o) { o.front_overlap = 1.0; }));
  EXPECT_TRUE(fails([](TrajectoryOptions& o) { o.max_tilt_rad = 1.0; }));
  EXPECT_TRUE(fails([](TrajectoryOptions& o) { o.speed_mps = 0.0; }));
}

}  // namespace
}  // namespace skyquilt::simulate
