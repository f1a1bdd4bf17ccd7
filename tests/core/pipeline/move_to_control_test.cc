// A flight whose truth is known, displaced as a whole, and brought back by a few surveyed points.
#include <gtest/gtest.h>

#include "core/flight/remarks/remark_words.h"
#include "core/pipeline/placing/place_by_lists.h"
#include "tests/core/pipeline/displaced_flight.h"

namespace skyquilt::pipeline {
namespace {

class BySomePoints : public testing::TestWithParam<std::size_t> {};

TEST_P(BySomePoints, AShiftedFlightComesBack) {
  const Displaced flight({0.0, 1.0, {1.9, -2.6}});
  EXPECT_GT(flight.WorstCameraM(flight.known), 3.0);
  const auto moved = MoveToControl(flight.known, flight.Survey(GetParam()));
  ASSERT_TRUE(moved.has_value());
  EXPECT_LT(flight.WorstCameraM(*moved), 0.01);
  EXPECT_FALSE(moved->appearance.has_value());
  EXPECT_EQ(moved->flight.warnings.size(), 1u);
}

INSTANTIATE_TEST_SUITE_P(OneToFour, BySomePoints, testing::Values(1u, 2u, 3u, 4u));

TEST(MoveToControl, TurnsAndStretchesByPointsThatLieFarApart) {
  Displaced flight({0.02, 1.01, {-1.2, 0.7}});
  EXPECT_GT(flight.WorstTurnRad(flight.known), 0.015);
  // As far as it truly moved while it read its rows, turned and stretched with the flight.
  const Eigen::Vector3d truly_m(1e-3, -2e-3, 5e-4);
  flight.known.flight.photos.front().readout_motion.shift_in_enu_m =
      1.01 * (Eigen::AngleAxisd(0.02, Eigen::Vector3d::UnitZ()) * truly_m);
  for (const std::size_t points : {2u, 3u, 4u}) {
    const auto moved = MoveToControl(flight.known, flight.Survey(points));
    ASSERT_TRUE(moved.has_value());
    EXPECT_LT(flight.WorstCameraM(*moved), 0.01);
    EXPECT_LT(flight.WorstTurnRad(*moved), 1e-4);
    EXPECT_LT((moved->flight.photos.front().readout_motion.shift_in_enu_m - truly_m).norm(), 1e-6);
    EXPECT_LT(moved->flight.photos.front().error_radius_m, 0.1);
  }
}

TEST(MoveToControl, TakesTheGroundAlong) {
  Displaced flight({0.0, 1.0, {2.0, 0.0}});
  // A ramp that rises to the east, one metre in ten.
  std::vector<float> heights_m;
  for (int row = 0; row < 21; ++row) {
    for (int column = 0; column < 21; ++column) heights_m.push_back(static_cast<float>(column - 10));
  }
  flight.known.ground =
      ground::GroundSurface::Grid({-100.0, -100.0}, 10.0, 21, 21, std::move(heights_m), 0.0);
  const auto moved = MoveToControl(flight.known, flight.Survey(1));
  ASSERT_TRUE(moved.has_value());
  for (const double east : {-50.0, 3.0, 41.0}) {
    EXPECT_NEAR(moved->ground.HeightAt({east, 5.0}), flight.known.ground.HeightAt({east + 2.0, 5.0}), 1e-3);
  }
}

TEST(MoveToControl, OfLessThanAnyPixelWouldShowChangesNothing) {
  const Displaced flight({0.0, 1.0, {0.0002, 0.0}});
  const auto moved = MoveToControl(flight.known, flight.Survey(3));
  ASSERT_TRUE(moved.has_value());
  EXPECT_TRUE(moved->appearance.has_value());
  EXPECT_EQ(flight.WorstCameraM(*moved), flight.WorstCameraM(flight.known));
  EXPECT_TRUE(moved->flight.warnings.empty());
}

TEST(MoveToControl, LeavesManyPointsToTheAlignment) {
  const Displaced flight({0.0, 1.0, {1.0, 1.0}});
  EXPECT_FALSE(MoveToControl(flight.known, flight.Survey(5)).has_value());
  EXPECT_FALSE(MoveToControl(flight.known, {}).has_value());
}

TEST(MoveToControl, LeavesPointsThatOnlyABentFlightFitsToTheAlignment) {
  const Displaced flight({0.0, 1.0, {1.0, 1.0}});
  EXPECT_FALSE(MoveToControl(flight.known, flight.Survey(4, {1.5, 0.0, 0.0})).has_value());
  const Displaced turned({0.2, 1.0, {}});
  EXPECT_FALSE(MoveToControl(turned.known, turned.Survey(3)).has_value());
}

TEST(MoveToControl, NamesAPointThatItCannotUse) {
  const Displaced flight({0.0, 1.0, {1.0, 0.0}});
  std::vector<flight::GcpList> lists = flight.Survey(2);
  std::vector<flight::GcpSighting>& sightings = lists.front().sightings;
  const auto first_of_second = std::find_if(sightings.begin(), sightings.end(),
                                            [](const flight::GcpSighting& one) { return one.point == 1; });
  sightings.erase(first_of_second + 1, sightings.end());
  const auto moved = MoveToControl(flight.known, lists);
  ASSERT_TRUE(moved.has_value());
  EXPECT_LT(flight.WorstCameraM(*moved), 0.01);
  ASSERT_EQ(moved->flight.warnings.size(), 2u);
  EXPECT_NE(InWords(moved->flight.warnings.front()).find("point1 is not used"), std::string::npos);
}

TEST(MoveToControl, ASinglePointMakesNoOneSurer) {
  const Displaced flight({0.0, 1.0, {1.0, 0.0}});
  const auto moved = MoveToControl(flight.known, flight.Survey(1));
  ASSERT_TRUE(moved.has_value());
  EXPECT_EQ(moved->flight.photos.front().error_radius_m, 1.5);
}

}  // namespace
}  // namespace skyquilt::pipeline
