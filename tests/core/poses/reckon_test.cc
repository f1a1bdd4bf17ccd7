#include "tests/bench/poses/reckon.h"

#include <gtest/gtest.h>

#include "tests/support/value_of.h"

namespace skyquilt::poses {
namespace {

constexpr double kSpeedMps = 6.0;
constexpr double kTurnRadps = 0.05;

// Level flight northwards at constant speed while the body turns about its vertical, 80 s at 50 Hz, 20 m
// high.
flight::FlightLog SteadyFlight() {
  flight::FlightLog log;
  log.file_name = "steady.bin";
  const double gravity = NormalGravityMps2(47.0, 420.0);
  for (int i = 0; i <= 4000; ++i) {
    const double t = 0.02 * i;
    log.imu.push_back({t, {0.0, 0.0, kTurnRadps}, {0.0, 0.0, -gravity}});
    if (i % 5 == 0) {
      const Eigen::Quaterniond ned_from_body(Eigen::AngleAxisd(kTurnRadps * t, Eigen::Vector3d::UnitZ()));
      log.attitude.push_back({t, ned_from_body, true});
    }
    if (i % 10 == 0) {
      flight::GnssSample fix;
      fix.t_s = t;
      fix.position = {47.0 + kSpeedMps * t / 111'170.0, 8.0};
      fix.height_amsl_m = 420.0;
      fix.velocity_in_ned_mps = Eigen::Vector3d(kSpeedMps, 0.0, 0.0);
      log.gnss.push_back(fix);
      log.baro.push_back({t, 20.0});
    }
  }
  return log;
}

TEST(Reckon, StaysOnACourseThatIsMeasuredWell) {
  const auto drifts = test::ValueOf(DriftsOfReckoning(SteadyFlight()));
  ASSERT_EQ(drifts.size(), 3u);
  for (const ReckonedDrift& drift : drifts) {
    EXPECT_GT(drift.windows, 0);
    EXPECT_LT(drift.trapezoid_rms_m, 0.05 * drift.length_s);
    EXPECT_LT(drift.simpson_rms_m, 0.05 * drift.length_s);
  }
}

TEST(Reckon, DriftsByTheAccelerometersBias) {
  flight::FlightLog log = SteadyFlight();
  constexpr double kBiasMps2 = 0.1;
  // The body turns, so that a bias in its frame would not grow with the square of time: it is laid along the
  // vertical of the turn and tilted into the level by turning the flight off.
  for (flight::ImuSample& sample : log.imu) {
    sample.angular_rate_radps.setZero();
    sample.specific_force_mps2.x() += kBiasMps2;
  }
  for (flight::AttitudeSample& sample : log.attitude) sample.ned_from_body.setIdentity();
  const auto drifts = test::ValueOf(DriftsOfReckoning(log));
  ASSERT_EQ(drifts.size(), 3u);
  EXPECT_NEAR(drifts[0].trapezoid_rms_m, 0.5 * kBiasMps2 * 100.0, 0.5);
  EXPECT_NEAR(drifts[1].simpson_rms_m, 0.5 * kBiasMps2 * 900.0, 2.0);
}

TEST(Reckon, PassesOverWindowsWithoutSamples) {
  flight::FlightLog log = SteadyFlight();
  const auto whole = DriftsOfReckoning(log);
  std::erase_if(log.imu,
                [](const flight::ImuSample& sample) { return sample.t_s > 11.0 && sample.t_s < 13.0; });
  const auto with_hole = DriftsOfReckoning(log);
  ASSERT_TRUE(whole.ok() && with_hole.ok());
  EXPECT_LT((*with_hole)[0].windows, (*whole)[0].windows);
}

TEST(Reckon, SaysWhatTheLogLacks) {
  flight::FlightLog log = SteadyFlight();
  log.attitude.clear();
  const Error drifts = test::ErrorOf(DriftsOfReckoning(log));
  EXPECT_EQ(drifts.code, ErrorCode::kUnprocessable);
  EXPECT_NE(drifts.message.find("attitudes"), std::string::npos);
}

}  // namespace
}  // namespace skyquilt::poses
