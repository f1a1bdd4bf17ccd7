#include <gtest/gtest.h>

#include <cmath>

#include "core/geo/lat_lon.h"
#include "core/poses/conventions/attitude_convention.h"
#include "core/poses/smoother/chain_problem.h"

namespace skyquilt::poses {
namespace {

struct Track {
  std::vector<KnotState> knots;
  std::vector<double> times_s;

  void Add(double course_deg, double nose_deg, double speed_mps = 8.0) {
    KnotState knot;
    const double course_rad = geo::DegToRad(course_deg);
    knot.velocity_in_enu_mps = speed_mps * Eigen::Vector3d(std::sin(course_rad), std::cos(course_rad), 0.0);
    knot.enu_from_body = EnuFromNed() * NedFromBody(geo::DegToRad(nose_deg), 0.0, 0.0);
    times_s.push_back(static_cast<double>(knots.size()));
    knots.push_back(knot);
  }
};

TEST(CourseEvidence, MeasuresHowWellTheNoseKeepsToTheCourse) {
  Track track;
  for (int k = 0; k < 40; ++k) track.Add(170.0, 170.0 + 6.0 * std::sin(0.2 * k));
  const auto evidence = JudgeCourse(track.knots, track.times_s, 3.0);
  ASSERT_TRUE(evidence.has_value());
  EXPECT_NEAR(geo::RadToDeg(evidence->sigma_rad), 1.4826 * 6.0 / std::sqrt(2.0), 0.8);
  EXPECT_FALSE(evidence->runs_straight.front());
  EXPECT_TRUE(evidence->runs_straight[20]);
}

TEST(CourseEvidence, IsNoBetterThanTwoDegrees) {
  Track track;
  for (int k = 0; k < 40; ++k) track.Add(10.0, 10.0);
  EXPECT_NEAR(JudgeCourse(track.knots, track.times_s, 3.0)->sigma_rad, 0.035, 1e-9);
}

TEST(CourseEvidence, SaysNothingOfFlightsSidewaysOrSlow) {
  Track sideways, slow, few;
  for (int k = 0; k < 40; ++k) sideways.Add(90.0, 1.0);
  for (int k = 0; k < 40; ++k) slow.Add(90.0, 90.0, 1.0);
  for (int k = 0; k < 9; ++k) few.Add(90.0, 90.0);
  EXPECT_FALSE(JudgeCourse(sideways.knots, sideways.times_s, 3.0));
  EXPECT_FALSE(JudgeCourse(slow.knots, slow.times_s, 3.0));
  EXPECT_FALSE(JudgeCourse(few.knots, few.times_s, 3.0));
}

TEST(CourseEvidence, LeavesTurnsOut) {
  Track track;
  for (int k = 0; k < 20; ++k) track.Add(0.0, 0.0);
  for (int k = 0; k < 9; ++k) track.Add(20.0 * k, 180.0 - 20.0 * k);
  for (int k = 0; k < 20; ++k) track.Add(180.0, 180.0);
  const auto evidence = JudgeCourse(track.knots, track.times_s, 3.0);
  ASSERT_TRUE(evidence.has_value());
  for (std::size_t k = 20; k < 29; ++k) EXPECT_FALSE(evidence->runs_straight[k]) << k;
  EXPECT_TRUE(evidence->runs_straight[10]);
  EXPECT_TRUE(evidence->runs_straight[40]);
}

}  // namespace
}  // namespace skyquilt::poses
