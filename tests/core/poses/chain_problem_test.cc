#include "core/poses/smoother/chain_problem.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

#include "core/flight/logs/log_builder.h"
#include "core/geo/lat_lon.h"
#include "core/poses/conventions/attitude_convention.h"
#include "tests/support/value_of.h"

namespace skyquilt::poses {
namespace {

struct System {
  BlockSkyline sparse;
  Eigen::MatrixXd dense;
};

// A random positive definite matrix inside the outline.
System RandomSystem(std::vector<int> first, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const int n = static_cast<int>(first.size());
  System system{BlockSkyline(first), Eigen::MatrixXd::Zero(n * kStateSize, n * kStateSize)};
  for (int j = 0; j < n; ++j) {
    for (int i = first[static_cast<std::size_t>(j)]; i <= j; ++i) {
      Matrix22 block = Matrix22::NullaryExpr([&] { return normal(random); });
      if (i == j) block = (block * block.transpose() + 400.0 * Matrix22::Identity()).eval();
      system.sparse.At(j, i) = block;
      system.dense.block<kStateSize, kStateSize>(j * kStateSize, i * kStateSize) = block;
      system.dense.block<kStateSize, kStateSize>(i * kStateSize, j * kStateSize) = block.transpose();
    }
  }
  return system;
}

const std::vector<std::vector<int>> kOutlines = {
    {0},
    {0, 0, 1, 2, 3},              // chain
    {0, 0, 1, 2, 0, 4, 5, 3},     // chain with links
    {0, 0, 1, 2, 3, 4, 0},        // chain with border
    {0, 0, 1, 2, 0, 4, 5, 3, 0},  // all of it
};

TEST(BlockSkyline, SolvesLikeADenseSolver) {
  for (const std::vector<int>& outline : kOutlines) {
    System system = RandomSystem(outline, outline.size());
    std::vector<Vector22> x(outline.size());
    Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(system.dense.rows(), -1.0, 2.0);
    for (std::size_t k = 0; k < x.size(); ++k) x[k] = b.segment<kStateSize>(static_cast<int>(k) * kStateSize);
    ASSERT_TRUE(system.sparse.Factor());
    system.sparse.Solve(x);
    const Eigen::VectorXd expected = system.dense.ldlt().solve(b);
    for (std::size_t k = 0; k < x.size(); ++k) {
      EXPECT_LT((x[k] - expected.segment<kStateSize>(static_cast<int>(k) * kStateSize)).norm(), 1e-12);
    }
  }
}

TEST(BlockSkyline, GivesTheBlocksOfTheDenseInverse) {
  for (const std::vector<int>& outline : kOutlines) {
    System system = RandomSystem(outline, 7 + outline.size());
    const Eigen::MatrixXd expected = system.dense.inverse();
    ASSERT_TRUE(system.sparse.Factor());
    system.sparse.SelectedInverse();
    for (int j = 0; j < system.sparse.size(); ++j) {
      for (int i = system.sparse.First(j); i <= j; ++i) {
        const Matrix22 block = expected.block<kStateSize, kStateSize>(j * kStateSize, i * kStateSize);
        EXPECT_LT((system.sparse.At(j, i) - block).norm(), 1e-12) << j << "," << i;
      }
    }
  }
}

TEST(BlockSkyline, RefusesAMatrixThatIsNotPositiveDefinite) {
  System system = RandomSystem({0, 0, 1}, 3);
  system.sparse.At(1, 1)(4, 4) = -1.0;
  EXPECT_FALSE(system.sparse.Factor());
  System not_a_number = RandomSystem({0, 0, 1}, 3);
  not_a_number.sparse.At(2, 1)(0, 0) = std::nan("");
  EXPECT_FALSE(not_a_number.sparse.Factor());
}

struct Track {
  std::vector<KnotState> knots;
  std::vector<double> times_s;

  void Add(double course_deg, double nose_deg, double speed_mps = 8.0) {
    KnotState knot;
    const double course_rad = geo::DegToRad(course_deg);
    knot.velocity_in_enu_mps = speed_mps * Eigen::Vector3d(std::sin(course_rad), std::cos(course_rad), 0.0);
    knot.enu_from_body = EnuFromNed() * flight::NedFromYawPitchRoll(geo::DegToRad(nose_deg), 0.0, 0.0);
    times_s.push_back(static_cast<double>(knots.size()));
    knots.push_back(knot);
  }
};

TEST(CourseEvidence, MeasuresHowWellTheNoseKeepsToTheCourse) {
  Track track;
  for (int k = 0; k < 40; ++k) track.Add(170.0, 170.0 + 6.0 * std::sin(0.2 * k));
  const auto evidence = test::ValueOf(JudgeCourse(track.knots, track.times_s));
  EXPECT_NEAR(geo::RadToDeg(evidence.sigma_rad), 1.4826 * 6.0 / std::sqrt(2.0), 0.8);
  EXPECT_FALSE(evidence.runs_straight.front());
  EXPECT_TRUE(evidence.runs_straight[20]);
}

TEST(CourseEvidence, IsNoBetterThanTwoDegrees) {
  Track track;
  for (int k = 0; k < 40; ++k) track.Add(10.0, 10.0);
  EXPECT_NEAR(JudgeCourse(track.knots, track.times_s)->sigma_rad, 0.035, 1e-9);
}

TEST(CourseEvidence, SaysNothingOfFlightsSidewaysOrSlow) {
  Track sideways, slow, few;
  for (int k = 0; k < 40; ++k) sideways.Add(90.0, 1.0);
  for (int k = 0; k < 40; ++k) slow.Add(90.0, 90.0, 1.0);
  for (int k = 0; k < 9; ++k) few.Add(90.0, 90.0);
  EXPECT_FALSE(JudgeCourse(sideways.knots, sideways.times_s));
  EXPECT_FALSE(JudgeCourse(slow.knots, slow.times_s));
  EXPECT_FALSE(JudgeCourse(few.knots, few.times_s));
}

TEST(CourseEvidence, LeavesTurnsOut) {
  Track track;
  for (int k = 0; k < 20; ++k) track.Add(0.0, 0.0);
  for (int k = 0; k < 9; ++k) track.Add(20.0 * k, 180.0 - 20.0 * k);
  for (int k = 0; k < 20; ++k) track.Add(180.0, 180.0);
  const auto evidence = test::ValueOf(JudgeCourse(track.knots, track.times_s));
  for (std::size_t k = 20; k < 29; ++k) EXPECT_FALSE(evidence.runs_straight[k]) << k;
  EXPECT_TRUE(evidence.runs_straight[10]);
  EXPECT_TRUE(evidence.runs_straight[40]);
}

}  // namespace
}  // namespace skyquilt::poses
