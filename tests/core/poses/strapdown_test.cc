#include "tests/bench/poses/strapdown.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/poses/so3.h"
#include "tests/support/value_of.h"

namespace skyquilt::poses {
namespace {

using Eigen::Vector3d;

// A body that circles at constant rate about the vertical with its nose along the course: constant rates and
// forces in body, known path.
struct Circle {
  double radius = 20.0;
  double rate = 0.4;  // rad/s, counter-clockwise seen from above
  StrapdownState At(double t) const {
    StrapdownState s;
    const double a = rate * t;
    s.t_s = t;
    s.position_in_enu_m = radius * Vector3d(std::cos(a), std::sin(a), 0.0);
    s.velocity_in_enu_mps = radius * rate * Vector3d(-std::sin(a), std::cos(a), 0.0);
    Eigen::Matrix3d r;
    r.col(0) = s.velocity_in_enu_mps.normalized();
    r.col(2) = -Vector3d::UnitZ();
    r.col(1) = r.col(2).cross(r.col(0));
    s.enu_from_body = Eigen::Quaterniond(r);
    return s;
  }
  std::vector<flight::ImuSample> Samples(double hz, double seconds) const {
    std::vector<flight::ImuSample> samples;
    for (int k = 0; k <= static_cast<int>(std::lround(hz * seconds)); ++k) {
      // Turning left is a negative rate about the down axis; the pull to the centre is to the left (-y).
      samples.push_back(
          {k / hz, Vector3d(0, 0, -rate), Vector3d(0, -radius * rate * rate, -kStandardGravityMps2)});
    }
    return samples;
  }
};

TEST(Strapdown, FollowsACircleBackToItsStart) {
  const Circle circle;
  for (const IntegrationRule rule : {IntegrationRule::kTrapezoid, IntegrationRule::kSimpson}) {
    StrapdownOptions options;
    options.rule = rule;
    const auto path = test::ValueOf(IntegrateStrapdown(circle.Samples(100.0, 31.4), circle.At(0.0), options));
    for (const StrapdownState& s : path) {
      const StrapdownState truth = circle.At(s.t_s);
      ASSERT_LT((s.position_in_enu_m - truth.position_in_enu_m).norm(), 5e-3) << s.t_s;
      ASSERT_LT(s.enu_from_body.angularDistance(truth.enu_from_body), 1e-9);
    }
  }
}

TEST(Strapdown, StaysWhereItIsAtRest) {
  std::vector<flight::ImuSample> samples;
  for (int k = 0; k < 500; ++k)
    samples.push_back({0.01 * k, Vector3d::Zero(), {0, 0, -kStandardGravityMps2}});
  StrapdownState start;
  start.enu_from_body = Eigen::Quaterniond(Eigen::AngleAxisd(3.141592653589793, Vector3d::UnitX()));
  EXPECT_LT(test::ValueOf(IntegrateStrapdown(samples, start)).back().position_in_enu_m.norm(), 1e-9);
}

TEST(Strapdown, ErrsLessWithSmallerStepsAndLeastBySimpsonOnCleanMotion) {
  const Circle circle;
  const auto error = [&](double hz, IntegrationRule rule) {
    StrapdownOptions options;
    options.rule = rule;
    const auto path = IntegrateStrapdown(circle.Samples(hz, 20.0), circle.At(0.0), options);
    return (path->back().position_in_enu_m - circle.At(path->back().t_s).position_in_enu_m).norm();
  };
  const double coarse = error(10.0, IntegrationRule::kTrapezoid);
  EXPECT_NEAR(coarse / error(20.0, IntegrationRule::kTrapezoid), 4.0, 0.5);  // second order
  EXPECT_LT(error(10.0, IntegrationRule::kSimpson), 0.05 * coarse);
}

TEST(Strapdown, UsesTrueTimesWhenSamplesAreLost) {
  const Circle circle;
  std::vector<flight::ImuSample> samples = circle.Samples(100.0, 30.0);
  std::vector<flight::ImuSample> kept;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    if (k % 97 != 13) kept.push_back(samples[k]);
  }
  const auto path = test::ValueOf(IntegrateStrapdown(kept, circle.At(0.0)));
  EXPECT_LT((path.back().position_in_enu_m - circle.At(path.back().t_s).position_in_enu_m).norm(), 0.02);
}

TEST(Strapdown, RefusesTimesThatDoNotRiseAndValuesThatAreNotNumbers) {
  std::vector<flight::ImuSample> samples = Circle{}.Samples(10.0, 1.0);
  EXPECT_FALSE(IntegrateStrapdown({}, {}).ok());
  auto repeated = samples;
  repeated[4].t_s = repeated[3].t_s;
  EXPECT_EQ(IntegrateStrapdown(repeated, {}).error().code, ErrorCode::kUnprocessable);
  auto not_a_number = samples;
  not_a_number[2].specific_force_mps2.x() = std::nan("");
  EXPECT_EQ(IntegrateStrapdown(not_a_number, {}).error().code, ErrorCode::kUnprocessable);
}

TEST(Strapdown, KnowsGravityOnTheEllipsoid) {
  EXPECT_NEAR(NormalGravityMps2(0.0, 0.0), 9.7803, 1e-4);
  EXPECT_NEAR(NormalGravityMps2(90.0, 0.0), 9.8322, 1e-4);
  EXPECT_NEAR(NormalGravityMps2(45.0, 1000.0), 9.8061977 - 0.003086, 1e-4);
}

TEST(Preintegration, PredictsWhatTheStrapdownReaches) {
  const Circle circle;
  const auto samples = circle.Samples(200.0, 2.0);
  const auto sum =
      Preintegrate(samples, 0.3125, 1.8111, {1.0}, Vector3d::Zero(), Vector3d::Zero(), ImuNoise{});
  ASSERT_TRUE(sum.has_value());
  const auto knot = [&](double t) {
    KnotState k;
    const StrapdownState s = circle.At(t);
    k.enu_from_body = s.enu_from_body;
    k.velocity_in_enu_mps = s.velocity_in_enu_mps;
    k.position_in_enu_m = s.position_in_enu_m;
    return k;
  };
  const auto expect_at = [&](const ImuDelta& delta, double t) {
    const KnotState reached = delta.Predict(knot(0.3125), kStandardGravityMps2);
    EXPECT_NEAR(delta.duration_s, t - 0.3125, 1e-12);
    EXPECT_LT((reached.position_in_enu_m - circle.At(t).position_in_enu_m).norm(), 1e-4);
    EXPECT_LT((reached.velocity_in_enu_mps - circle.At(t).velocity_in_enu_mps).norm(), 1e-4);
    EXPECT_LT(reached.enu_from_body.angularDistance(circle.At(t).enu_from_body), 1e-9);
  };
  expect_at(sum->at_cuts.at(0), 1.0);
  expect_at(sum->delta, 1.8111);
}

TEST(Preintegration, CorrectsForBiasesToFirstOrder) {
  const auto samples = Circle{}.Samples(100.0, 1.0);
  const Vector3d gyro(2e-3, -1e-3, 3e-3), accel(0.02, -0.03, 0.01);
  const auto about_zero = Preintegrate(samples, 0.1, 0.6, {}, Vector3d::Zero(), Vector3d::Zero(), ImuNoise{});
  const auto about_bias = Preintegrate(samples, 0.1, 0.6, {}, gyro, accel, ImuNoise{});
  KnotState biased;
  biased.gyro_bias_radps = gyro;
  biased.accel_bias_mps2 = accel;
  const KnotState a = about_zero->delta.Predict(biased, 9.81);
  const KnotState b = about_bias->delta.Predict(biased, 9.81);
  EXPECT_LT((a.position_in_enu_m - b.position_in_enu_m).norm(), 5e-6);
  EXPECT_LT((a.velocity_in_enu_mps - b.velocity_in_enu_mps).norm(), 3e-5);
  EXPECT_LT(a.enu_from_body.angularDistance(b.enu_from_body), 1e-6);
}

TEST(Preintegration, GrowsItsCovarianceAsWhiteNoiseDoes) {
  std::vector<flight::ImuSample> samples;
  for (int k = 0; k <= 200; ++k) samples.push_back({0.01 * k, Vector3d::Zero(), Vector3d::Zero()});
  const ImuNoise noise;
  const auto sum = Preintegrate(samples, 0.0, 2.0, {}, Vector3d::Zero(), Vector3d::Zero(), noise);
  const double variance = noise.accel_white * noise.accel_white;
  EXPECT_NEAR(sum->covariance(0, 0), noise.gyro_white * noise.gyro_white * 2.0, 1e-12);
  EXPECT_NEAR(sum->covariance(3, 3) / (variance * 2.0), 1.0, 1e-6);
  EXPECT_NEAR(sum->covariance(6, 6) / (variance * 8.0 / 3.0), 1.0, 1e-3);
  EXPECT_NEAR(sum->covariance(3, 6) / (variance * 2.0), 1.0, 1e-3);
}

TEST(Preintegration, SaysNothingAcrossAHole) {
  std::vector<flight::ImuSample> samples;
  for (int k = 0; k <= 100; ++k) {
    if (k > 40 && k < 70) continue;
    samples.push_back({0.01 * k, Vector3d::Zero(), Vector3d::Zero()});
  }
  const auto over = [&](double a, double b) {
    return Preintegrate(samples, a, b, {}, Vector3d::Zero(), Vector3d::Zero(), ImuNoise{}).has_value();
  };
  EXPECT_TRUE(over(0.0, 0.4));
  EXPECT_FALSE(over(0.2, 0.8));
  EXPECT_FALSE(over(0.45, 0.65));
  EXPECT_FALSE(over(0.8, 1.5));
}

}  // namespace
}  // namespace skyquilt::poses
