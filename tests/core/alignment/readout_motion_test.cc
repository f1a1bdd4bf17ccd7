// How gyro and speed become the motion of rows, what of it the images may correct, and the cost of that.
#include "core/alignment/bundle/readout_motion.h"

#include <memory>

#include "core/alignment/bundle/reprojection_cost.h"
#include "tests/core/alignment/cost_derivatives.h"

namespace skyquilt::alignment {
namespace {

flight::RecordedTurning Turning(double from_s, double to_s, const Eigen::Vector3d& rate_radps,
                                const Eigen::Vector3d& faster_radps2 = Eigen::Vector3d::Zero()) {
  flight::RecordedTurning turning;
  for (double time_s = from_s; time_s <= to_s; time_s += 0.001)
    turning.samples.push_back({time_s, rate_radps + time_s * faster_radps2});
  return turning;
}

TEST(TurnsOfRows, CarryAPointAgainstTheCamerasTurn) {
  // The image's right side goes away from the viewer: a point straight ahead moves to the left.
  const std::vector<Eigen::Vector3d> turns = TurnsOfRows(Turning(-0.01, 0.11, {0.0, 0.4, 0.0}), 0.1, 0.0);
  ASSERT_GE(turns.size(), 3U);
  const camera::RowMotion motion{Eigen::Vector3d::Zero(), turns};
  EXPECT_LT((motion.TurnAt(0.0) * Eigen::Vector3d::UnitZ()).cwiseAbs().x(), 1e-6);
  EXPECT_NEAR((motion.TurnAt(0.5) * Eigen::Vector3d::UnitZ()).x(), -std::sin(0.02), 1e-6);
  EXPECT_NEAR((motion.TurnAt(-0.5) * Eigen::Vector3d::UnitZ()).x(), std::sin(0.02), 1e-6);
}

TEST(TurnsOfRows, GoOnBeyondTheRecordsAndNeedMostOfThem) {
  const Eigen::Vector3d rate(0.1, -0.2, 0.3);
  const auto whole = TurnsOfRows(Turning(-0.01, 0.11, rate), 0.1, 0.0);
  const auto cut = TurnsOfRows(Turning(-0.01, 0.07, rate), 0.1, 0.0);
  ASSERT_EQ(whole.size(), cut.size());
  for (std::size_t k = 0; k < whole.size(); ++k) EXPECT_LT((whole[k] - cut[k]).norm(), 1e-6);
  EXPECT_TRUE(TurnsOfRows(Turning(-0.01, 0.04, rate), 0.1, 0.0).empty());
  EXPECT_TRUE(TurnsOfRows({}, 0.1, 0.0).empty());
}

TEST(ReadoutMotion, TurnsWithThePictureThatAViewerTurned) {
  poses::PosedPhoto posed;
  posed.photo.readout_s = 0.1;
  posed.photo.turning = Turning(-0.01, 0.11, {0.1, 0.2, 0.3}, {1.0, 0.0, -2.0});
  const camera::RowMotion upright = ReadoutMotion(posed, 0);
  ASSERT_FALSE(upright.turns_rad.empty());
  posed.photo.is_resaved_by_viewer = true;
  const camera::RowMotion turned = ReadoutMotion(posed, 2);
  ASSERT_EQ(turned.turns_rad.size(), upright.turns_rad.size());
  const Eigen::Vector3d first = upright.turns_rad.front();
  EXPECT_TRUE(turned.turns_rad.back().isApprox(Eigen::Vector3d(-first.x(), -first.y(), first.z())));
  EXPECT_TRUE(ReadoutMotion(posed, 1).IsStill());
  // What a finished flight found goes before the record.
  posed.readout_motion = camera::RowMotion{};
  EXPECT_TRUE(ReadoutMotion(posed, 0).IsStill());
}

TEST(ReadoutCorrection, ALagReadsTheGyroLater) {
  const flight::RecordedTurning turning = Turning(-0.05, 0.15, {0.1, 0.2, -0.3}, {3.0, -2.0, 4.0});
  flight::RecordedTurning late = turning;
  for (flight::TurnRate& sample : late.samples) sample.time_s -= 0.002;
  const camera::RowMotion motion{Eigen::Vector3d::Zero(), TurnsOfRows(turning, 0.1, 0.0)};
  const camera::RowMotion expected{Eigen::Vector3d::Zero(), TurnsOfRows(late, 0.1, 0.0)};
  ReadoutDoubt doubt;
  ReadoutCorrection correction = ReadoutCorrection::Zero();
  correction[9] = 0.02;
  const camera::RowMotion corrected = Corrected(motion, doubt, correction);
  double moved = 0.0;
  for (std::size_t k = 0; k < corrected.turns_rad.size(); ++k) {
    EXPECT_LT((corrected.turns_rad[k] - expected.turns_rad[k]).norm(), 5e-5);
    moved = std::max(moved, (motion.turns_rad[k] - expected.turns_rad[k]).norm());
  }
  EXPECT_GT(moved, 3e-4);
}

// The cost at the corrected motion is the cost of the motion with its correction, and its derivatives are
// those of its values.
TEST(TurningReprojectionCost, AgreesWithTheCorrectedMotionAndItsOwnDerivatives) {
  const geo::Rigid3 start = geo::Rigid3::FromRotationAndTargetOrigin(
      Eigen::Quaterniond(Eigen::AngleAxisd(3.0, Eigen::Vector3d(1.0, 0.2, 0.1).normalized())),
      {4.0, -3.0, 60.0});
  const camera::Intrinsics lens = camera::Intrinsics::Centered(2000, 1500, 1400.0);
  const Eigen::Vector2d pixel(1200.0, 1320.0);
  const camera::RowMotion motion{
      {1.0, -2.0, 0.1}, TurnsOfRows(Turning(-0.01, 0.09, {0.3, 0.2, -0.3}, {3.0, -2.0, 4.0}), 0.1, 0.0)};
  ReadoutDoubt doubt;
  doubt.known_to_share = 0.3;
  CostValues values{{0.02, -0.05, 0.03, 0.5, -0.4, 0.8},
                    {10.0, 6.0, 2.0},
                    {0.01, 3.0, -2.0, -0.1, 0.05, 0.001, -0.002},
                    {0.002, -0.001, 0.003, 0.02, -0.01, 0.03, 0.001, 0.004, -0.002, 0.01}};
  const auto cost_of = [&](const camera::RowMotion& moves) {
    return std::unique_ptr<ceres::CostFunction>(
        MakeTurningReprojectionCost(start, moves, doubt, lens, pixel, 0.7));
  };
  const auto residual = [&](const camera::RowMotion& moves) { return ResidualAt(*cost_of(moves), values); };
  const Eigen::Vector2d with_correction = residual(motion);
  ExpectOwnDerivatives(*cost_of(motion), values, 1e-3);
  const ReadoutCorrection correction = Eigen::Map<const ReadoutCorrection>(values[3].data());
  values[3].assign(10, 0.0);
  EXPECT_LT((residual(Corrected(motion, doubt, correction)) - with_correction).norm(), 0.05);
  EXPECT_GT((residual(motion) - with_correction).norm(), 1.0);
}

}  // namespace
}  // namespace skyquilt::alignment
