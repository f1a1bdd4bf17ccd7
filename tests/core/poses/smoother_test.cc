#include "core/poses/smoother/smoother.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/bench/poses/input_mixes.h"
#include "tests/bench/poses/pose_metrics.h"
#include "tests/support/value_of.h"

namespace skyquilt::poses {
namespace {

using bench::AnalyticFlight;
using bench::InputMix;
using Eigen::Vector3d;

bench::FlightPlan ShortPlan() {
  bench::FlightPlan plan;
  plan.legs = 2;
  plan.leg_m = 120.0;
  plan.height_m = 40.0;
  return plan;
}

SmootherInput Input(InputMix mix, std::uint64_t seed, const AnalyticFlight& flight) {
  return bench::InputOf(mix, flight, bench::RecordSensors(flight, bench::ErrorsOf(mix), seed));
}

TEST(SmoothChain, StatesErrorsThatAreTrueForEveryMixOfInputs) {
  for (const InputMix mix : {InputMix::kImuBaroStartEnd, InputMix::kGnssAttitudeBaro, InputMix::kGnssImuBaro,
                             InputMix::kGnssImuAttitudeBaro, InputMix::kRtkAttitude, InputMix::kRtkImu}) {
    double position = 0.0, rotation = 0.0;
    constexpr int kFlights = 6;
    for (std::uint64_t seed = 1; seed <= kFlights; ++seed) {
      const AnalyticFlight flight(ShortPlan(), seed);
      const auto output = test::ValueOf(SmoothChain(Input(mix, seed, flight)));
      EXPECT_TRUE(output.report.converged);
      const bench::PoseMetrics metrics = bench::Measure(flight, output);
      position += metrics.nees_position / kFlights;
      rotation += metrics.nees_rotation / kFlights;
    }
    // Few, strongly correlated samples: the mean of an honest estimate still strays.
    EXPECT_GT(position, 0.15) << static_cast<int>(mix);
    EXPECT_LT(position, 3.0) << static_cast<int>(mix);
    EXPECT_GT(rotation, 0.15) << static_cast<int>(mix);
    EXPECT_LT(rotation, 3.0) << static_cast<int>(mix);
  }
}

TEST(SmoothChain, GetsBetterWithEverySensor) {
  const AnalyticFlight flight(bench::FlightPlan{}, 3);
  const auto error = [&](InputMix mix) {
    return bench::Measure(flight, *SmoothChain(Input(mix, 3, flight)));
  };
  const bench::PoseMetrics reckoned = error(InputMix::kImuStart);
  const bench::PoseMetrics with_end = error(InputMix::kImuBaroStartEnd);
  const bench::PoseMetrics rtk = error(InputMix::kRtkImu);
  EXPECT_GT(reckoned.position_2d_m, 3.0 * with_end.position_2d_m);
  EXPECT_LT(rtk.position_2d_m, 0.05);
  EXPECT_LT(rtk.tilt_deg, 0.1);
}

TEST(SmoothChain, BridgesAHoleInTheInertialSamplesByTheMotionPrior) {
  const AnalyticFlight flight(ShortPlan(), 4);
  SmootherInput input = Input(InputMix::kGnssImuAttitudeBaro, 4, flight);
  std::erase_if(input.imu, [](const flight::ImuSample& s) { return s.t_s > 60.0 && s.t_s < 67.0; });
  const auto output = test::ValueOf(SmoothChain(input));
  EXPECT_GT(output.report.used.at("motion prior"), 10);
  const bench::PoseMetrics metrics = bench::Measure(flight, output);
  EXPECT_LT(metrics.position_2d_m, 4.0);
  EXPECT_LT(metrics.nees_position, 4.0);
}

TEST(SmoothChain, WeighsDownAJumpOfTheGnss) {
  const AnalyticFlight flight(ShortPlan(), 5);
  SmootherInput input = Input(InputMix::kGnssImuAttitudeBaro, 5, flight);
  const bench::PoseMetrics clean = bench::Measure(flight, *SmoothChain(input));
  for (PositionFix& f : input.positions) {
    if (f.t_s > 55.0 && f.t_s < 58.0) f.position_in_enu_m += Vector3d(30.0, -20.0, 5.0);
  }
  const auto output = test::ValueOf(SmoothChain(input));
  EXPECT_GE(output.report.down_weighted.at("gnss position"), 14);
  EXPECT_LT(bench::Measure(flight, output).worst_position_m, clean.worst_position_m + 1.5);
}

TEST(SmoothChain, FindsALateGnssClockAndItsAntenna) {
  const AnalyticFlight flight(bench::FlightPlan{}, 6);
  SmootherInput input = Input(InputMix::kRtkImu, 6, flight);
  const Vector3d lever(0.1, 0.0, -0.3);
  for (std::size_t k = 0; k < input.positions.size(); ++k) {
    const bench::FlightTruth truth = flight.At(input.positions[k].t_s);
    input.positions[k].position_in_enu_m += truth.enu_from_body * lever;
    input.positions[k].t_s += 0.12;  // stamped late
    input.velocities[k].t_s += 0.12;
  }
  input.options.tau_gnss_sigma_s = 0.2;
  input.options.lever_gnss_sigma_m = 0.5;
  const auto output = test::ValueOf(SmoothChain(input));
  EXPECT_NEAR(output.border.TauGnss(), -0.12, 0.01);
  EXPECT_LT((output.border.LeverGnss() - lever).head<2>().norm(), 0.05);
  EXPECT_LT(output.border_sigma(kAtTauGnss), 0.01);
  EXPECT_LT(bench::Measure(flight, output).tilt_deg, 0.2);
}

TEST(SmoothChain, CarriesTheCameraClockAndMountIntoTheErrors) {
  const AnalyticFlight flight(ShortPlan(), 7);
  SmootherInput input = Input(InputMix::kRtkImu, 7, flight);
  const auto exact = SmoothChain(input);
  input.options.tau_camera_sigma_s = 0.1;
  input.options.boresight_sigma_rad = 0.05;
  const auto loose = SmoothChain(input);
  ASSERT_TRUE(exact.ok() && loose.ok());
  const SmoothedPose& a = exact->poses[3];
  const SmoothedPose& b = loose->poses[3];
  const Matrix6d extra = b.covariance - a.covariance;
  const Vector3d along = 0.1 * a.velocity_in_enu_mps;
  EXPECT_NEAR(extra(3, 3) + extra(4, 4), along.head<2>().squaredNorm(), 0.1 * along.squaredNorm() + 1e-4);
  EXPECT_NEAR(extra(0, 0), 0.05 * 0.05, 0.05 * 0.05);
  // Both photos share these errors: their difference is as well known as before.
  const auto spread = [](const SmoothedPose& p, const SmoothedPose& next) {
    return (p.covariance + next.covariance - p.covariance_with_next - p.covariance_with_next.transpose())
        .bottomRightCorner<3, 3>()
        .trace();
  };
  EXPECT_LT(spread(b, loose->poses[4]), (0.3 * b.covariance.bottomRightCorner<3, 3>().trace()));
}

TEST(SmoothChain, GivesTheSameBytesTwice) {
  const AnalyticFlight flight(ShortPlan(), 8);
  const SmootherInput input = Input(InputMix::kGnssImuAttitudeBaro, 8, flight);
  const auto a = SmoothChain(input);
  const auto b = SmoothChain(input);
  for (std::size_t k = 0; k < a->poses.size(); ++k) {
    EXPECT_EQ(a->poses[k].position_in_enu_m, b->poses[k].position_in_enu_m);
    EXPECT_EQ(a->poses[k].covariance, b->poses[k].covariance);
  }
}

TEST(SmoothChain, DropsBadSamplesAndSaysSo) {
  const AnalyticFlight flight(ShortPlan(), 9);
  SmootherInput input = Input(InputMix::kGnssImuAttitudeBaro, 9, flight);
  input.imu[500].angular_rate_radps.x() = std::nan("");
  input.imu[600].t_s = input.imu[599].t_s;
  input.positions[10].position_in_enu_m.y() = INFINITY;
  input.attitudes[20].enu_from_body.coeffs().setZero();
  input.heights[5].sigma_m = -1.0;
  const auto output = test::ValueOf(SmoothChain(input));
  EXPECT_EQ(output.report.warnings.size(), 4u);
  EXPECT_LT(bench::Measure(flight, output).position_2d_m, 4.0);
}

TEST(SmoothChain, RefusesWhatCannotBePlaced) {
  SmootherInput nothing;
  EXPECT_EQ(SmoothChain(nothing).error().code, ErrorCode::kUnprocessable);
  const AnalyticFlight flight(ShortPlan(), 1);
  SmootherInput nowhere = Input(InputMix::kImuBaroStartEnd, 1, flight);
  nowhere.markers.clear();
  EXPECT_EQ(SmoothChain(nowhere).error().code, ErrorCode::kUnprocessable);
  SmootherInput disordered = Input(InputMix::kGnssAttitudeBaro, 1, flight);
  std::swap(disordered.photo_times_s[0], disordered.photo_times_s[3]);
  EXPECT_EQ(SmoothChain(disordered).error().code, ErrorCode::kUnprocessable);
  SmootherInput endless = Input(InputMix::kGnssAttitudeBaro, 1, flight);
  endless.photo_times_s.push_back(1e9);
  EXPECT_EQ(SmoothChain(endless).error().code, ErrorCode::kUnprocessable);
}

TEST(SmoothChain, PlacesASinglePhoto) {
  SmootherInput input;
  input.photo_times_s = {12.0};
  input.positions = {{12.0, Vector3d(5.0, 6.0, 70.0), Vector3d(0.5, 0.5, 1.0)}};
  input.attitudes = {{12.0, Eigen::Quaterniond(Eigen::AngleAxisd(3.0, Vector3d::UnitX())), 0.002, true}};
  const auto output = test::ValueOf(SmoothChain(input));
  const Vector3d expected(5.0, 6.0, 70.0);
  EXPECT_LT((output.poses[0].position_in_enu_m - expected).norm(), 0.01);
  EXPECT_NEAR(output.poses[0].covariance(3, 3), 1.25, 0.01);
}

}  // namespace
}  // namespace skyquilt::poses
