#include "core/simulate/sensors/sensors.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/geo/rigid3.h"
#include "tests/core/simulate/surveys.h"

namespace skyquilt::simulate {
namespace {

const flight::UtcTime kStart{std::chrono::seconds(1717236000)};
const geo::LocalFrame kFrame({46.8, 7.1, 500.0});

LoggedSurvey Fly(SurveyOptions options) {
  auto survey = FlySurvey(options, ReferenceCamera(), kFrame, kStart);
  SKYQUILT_CHECK(survey.ok(), "the reference survey can be flown");
  return *std::move(survey);
}

ImuModel PerfectImu(double rate_hz) {
  ImuModel imu;
  imu.rate_hz = rate_hz;
  imu.gyro_white = imu.accel_white = 0.0;
  imu.gyro_turn_on = imu.accel_turn_on = 0.0;
  imu.gyro_walk = imu.accel_walk = 0.0;
  return imu;
}

SurveyOptions Silent(std::uint32_t seed) {
  SurveyOptions options = ReferenceSurvey(seed);
  options.sensors.has_gnss = options.sensors.has_attitude = options.sensors.has_baro = false;
  return options;
}

TEST(ReferenceSurvey, IsTheFlightOnWhichPosesAreMeasured) {
  const LoggedSurvey survey = Fly(Silent(1));
  EXPECT_NEAR(survey.path.EndS(), 330.0, 40.0);
  ASSERT_EQ(survey.poses.size(), 95u);
  EXPECT_EQ(survey.poses.back().line, 4);
  const Eigen::Vector3d first = survey.poses[0].cam_from_enu.TargetOriginInSource();
  const Eigen::Vector3d last = survey.poses[18].cam_from_enu.TargetOriginInSource();
  EXPECT_NEAR((last - first).norm(), 250.0, 5.0);
  EXPECT_NEAR(first.z(), 60.0, 2.0);
  double lean = 0.0;
  for (const TruePose& pose : survey.poses) {
    lean += std::acos(-(pose.cam_from_enu.rotation.conjugate() * Eigen::Vector3d::UnitZ()).z()) / 95.0;
  }
  EXPECT_NEAR(geo::RadToDeg(lean), 11.5, 3.0) << "drag at 8 m/s leans a fixed camera";
}

TEST(FlightPath, StandsTrulyStillBeforeAndAfter) {
  const LoggedSurvey survey = Fly(Silent(2));
  const PathState start = survey.path.At(0.0);
  for (double t_s = 0.0; t_s <= 8.9; t_s += 0.1) {
    const PathState state = survey.path.At(t_s);
    EXPECT_EQ(state.point_in_enu, start.point_in_enu);
    EXPECT_LT(state.enu_from_body.angularDistance(start.enu_from_body), 1e-12);
  }
  const double end_s = survey.path.EndS();
  EXPECT_LT((survey.path.At(end_s - 4.5).point_in_enu - survey.path.At(end_s).point_in_enu).norm(), 1e-12);
  EXPECT_LT(survey.path.At(end_s).point_in_enu.norm(), 0.5) << "lands where it took off";
}

// A plain summation written here, in small steps: what the inertial unit feels must lead along the true path.
TEST(Sensors, PerfectInertialSamplesLeadAlongTheTruePath) {
  SurveyOptions options = Silent(3);
  options.sensors.imu = PerfectImu(500.0);
  const LoggedSurvey survey = Fly(options);
  PathState state = survey.path.At(0.0);
  Eigen::Quaterniond attitude = state.enu_from_body;
  Eigen::Vector3d velocity = state.velocity_in_enu_mps;
  Eigen::Vector3d point = state.point_in_enu;
  const double dt_s = 1.0 / 500.0;
  double end_s = 0.0;
  for (const flight::ImuSample& sample : survey.log.imu) {
    const Eigen::Quaterniond half =
        attitude * geo::RotationFromVector(0.5 * dt_s * sample.angular_rate_radps);
    const Eigen::Vector3d acceleration =
        half * sample.specific_force_mps2 - Eigen::Vector3d(0.0, 0.0, survey.path.gravity_mps2());
    point += dt_s * velocity + 0.5 * dt_s * dt_s * acceleration;
    velocity += dt_s * acceleration;
    attitude = (attitude * geo::RotationFromVector(dt_s * sample.angular_rate_radps)).normalized();
    end_s += dt_s;
    if (end_s >= 120.0) break;
  }
  const PathState truth = survey.path.At(end_s);
  EXPECT_LT((point - truth.point_in_enu).norm(), 0.02);
  EXPECT_LT((velocity - truth.velocity_in_enu_mps).norm(), 1e-3);
  EXPECT_LT(attitude.angularDistance(truth.enu_from_body), 1e-5);
}

TEST(Sensors, AtRestTheInertialUnitFeelsGravityUpwards) {
  SurveyOptions options = Silent(4);
  options.sensors.imu = PerfectImu(100.0);
  const LoggedSurvey survey = Fly(options);
  for (int i = 0; i < 800; ++i) {
    EXPECT_LT(
        (survey.log.imu[i].specific_force_mps2 - Eigen::Vector3d(0, 0, -survey.path.gravity_mps2())).norm(),
        1e-9);
    EXPECT_LT(survey.log.imu[i].angular_rate_radps.norm(), 1e-9);
  }
  EXPECT_NEAR(survey.path.gravity_mps2(), 9.807, 0.002);
}

TEST(Sensors, InertialNoiseHasTheDensityAskedFor) {
  SurveyOptions options = Silent(5);
  options.still_before_s = 120.0;
  options.sensors.imu = PerfectImu(200.0);
  options.sensors.imu.gyro_white = 1e-3;
  options.sensors.imu.accel_white = 2e-2;
  const LoggedSurvey survey = Fly(options);
  double gyro = 0.0;
  double accel = 0.0;
  constexpr int kCount = 23000;
  for (int i = 0; i < kCount; ++i) {
    gyro += survey.log.imu[i].angular_rate_radps.squaredNorm() / (3.0 * kCount);
    accel += (survey.log.imu[i].specific_force_mps2 + Eigen::Vector3d(0, 0, survey.path.gravity_mps2()))
                 .squaredNorm() /
             (3.0 * kCount);
  }
  EXPECT_NEAR(std::sqrt(gyro), 1e-3 * std::sqrt(200.0), 1e-3);
  EXPECT_NEAR(std::sqrt(accel), 2e-2 * std::sqrt(200.0), 1e-2);
}

TEST(Sensors, SatellitePositionsWanderAsModelled) {
  double squared = 0.0;
  double step_squared = 0.0;
  std::size_t count = 0;
  for (std::uint32_t seed = 1; seed <= 12; ++seed) {
    SurveyOptions options = ReferenceSurvey(seed);
    options.sensors.has_imu = false;
    const LoggedSurvey survey = Fly(options);
    Eigen::Vector3d last = Eigen::Vector3d::Zero();
    for (const flight::GnssSample& sample : survey.log.gnss) {
      const Eigen::Vector3d at =
          kFrame.EnuFromWgs84({sample.position.lat_deg, sample.position.lon_deg, *sample.height_ellipsoid_m});
      const Eigen::Vector3d error = at - survey.path.At(sample.t_s).point_in_enu;
      squared += error.head<2>().squaredNorm();
      if (count > 0) step_squared += (error - last).head<2>().squaredNorm();
      last = error;
      ++count;
    }
  }
  EXPECT_NEAR(std::sqrt(squared / static_cast<double>(count)), std::sqrt(2.0), 0.4);
  EXPECT_LT(std::sqrt(step_squared / static_cast<double>(count)), 0.5) << "neighbours share their error";
}

TEST(Sensors, LeaveOutWhatIsLostAndLateAndTooFar) {
  SurveyOptions options = ReferenceSurvey(6);
  options.sensors.imu = WithDefects(IcmClassImu(), 2.0);
  options.sensors.imu.gaps_s = {{100.0, 124.0}};
  options.sensors.gnss.outages_s = {{60.0, 90.0}};
  options.sensors.gnss.latency_s = 0.15;
  options.sensors.has_range = true;
  options.sensors.events.lost_share = 0.1;
  options.sensors.events.doubled_share = 0.1;
  const LoggedSurvey survey = Fly(options);
  for (std::size_t i = 1; i < survey.log.imu.size(); ++i) {
    EXPECT_GT(survey.log.imu[i].t_s, survey.log.imu[i - 1].t_s);
    const double t_s = survey.log.imu[i].t_s;
    EXPECT_FALSE(t_s > 100.01 && t_s < 123.99) << t_s;
  }
  const double expected = (survey.path.EndS() - 24.0) * 250.0;
  EXPECT_LT(static_cast<double>(survey.log.imu.size()), 0.995 * expected);
  EXPECT_GT(static_cast<double>(survey.log.imu.size()), 0.98 * expected);
  for (const flight::GnssSample& sample : survey.log.gnss)
    EXPECT_FALSE(sample.t_s > 60.3 && sample.t_s < 90.0);
  ASSERT_FALSE(survey.log.range.empty());
  for (const flight::RangeSample& sample : survey.log.range) {
    EXPECT_LT(sample.distance_m, 28.0);
    EXPECT_LT(survey.path.At(sample.t_s).point_in_enu.z(), 25.0);
  }
  int missing = 0;
  int doubled = 0;
  for (const TruePose& pose : survey.poses) {
    int near = 0;
    for (const flight::CameraEvent& event : survey.log.events)
      near += std::abs(event.t_s - pose.t_s) < 0.1 ? 1 : 0;
    missing += near == 0 ? 1 : 0;
    doubled += near == 2 ? 1 : 0;
  }
  EXPECT_GT(missing, 2);
  EXPECT_GT(doubled, 2);
}

TEST(Sensors, OneSensorMoreDoesNotChangeTheOthers) {
  SurveyOptions options = ReferenceSurvey(7);
  options.sensors.has_imu = false;
  const LoggedSurvey with = Fly(options);
  options.sensors.has_baro = false;
  const LoggedSurvey without = Fly(options);
  ASSERT_EQ(with.log.gnss.size(), without.log.gnss.size());
  EXPECT_EQ(with.log.gnss.back().position.lat_deg, without.log.gnss.back().position.lat_deg);
  EXPECT_TRUE(without.log.baro.empty());
}

TEST(PaperHop, IsAShortLowFlightInReachOfTheRangeFinder) {
  const LoggedSurvey survey = Fly(PaperHop(1));
  EXPECT_NEAR(survey.path.EndS(), 75.0, 15.0);
  EXPECT_TRUE(survey.log.gnss.empty());
  EXPECT_GT(static_cast<double>(survey.log.range.size()), 0.7 * 10.0 * survey.path.EndS());
}

}  // namespace
}  // namespace skyquilt::simulate
