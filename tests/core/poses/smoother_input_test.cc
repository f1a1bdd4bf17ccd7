#include "core/poses/evidence/smoother_input.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/poses/conventions/attitude_convention.h"
#include "core/poses/place_by_log.h"
#include "tests/bench/poses/recorded_sensors.h"
#include "tests/support/value_of.h"

namespace skyquilt::poses {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

const geo::LocalFrame& Frame() {
  static const geo::LocalFrame frame({47.4, 8.5, 450.0});
  return frame;
}

// A recorded flight as a log and as photos with XMP, both in geographic terms.
struct Recorded {
  bench::AnalyticFlight flight;
  bench::RecordedSensors sensors;
  flight::FlightLog log;
  std::vector<flight::Photo> photos;

  explicit Recorded(std::uint64_t seed, bool with_gimbal = false) : flight(Plan(), seed) {
    sensors = bench::RecordSensors(flight, {}, seed);
    log.imu = sensors.imu;
    for (const AttitudeFix& a : sensors.attitudes) {
      log.attitude.push_back({a.t_s, EnuFromNed().conjugate() * a.enu_from_body, true});
    }
    for (std::size_t k = 0; k < sensors.positions.size(); ++k) {
      const geo::Wgs84 at = Frame().Wgs84FromEnu(sensors.positions[k].position_in_enu_m);
      const Vector3d v = sensors.velocities[k].velocity_in_enu_mps;
      flight::GnssSample s;
      s.t_s = sensors.positions[k].t_s;
      s.position = {at.lat_deg, at.lon_deg};
      s.height_ellipsoid_m = at.height_ellipsoid_m;
      s.velocity_in_ned_mps = Vector3d(v.y(), v.x(), -v.z());
      log.gnss.push_back(s);
    }
    for (const HeightFix& h : sensors.heights) log.baro.push_back({h.t_s, h.z_in_enu_m});
    for (const RangeFix& r : sensors.ranges) log.range.push_back({r.t_s, r.distance_m});
    for (std::size_t k = 0; k < flight.photo_times_s().size(); ++k) {
      flight::Photo photo;
      const geo::Wgs84 at = Frame().Wgs84FromEnu(sensors.photo_positions[k].position_in_enu_m);
      photo.position.emplace();
      photo.position->position = {at.lat_deg, at.lon_deg};
      photo.position->height_above_takeoff_m = sensors.photo_heights[k].z_in_enu_m;
      const Vector3d v = sensors.photo_velocities[k].velocity_in_enu_mps;
      photo.velocity_in_enu_mps = v;
      if (with_gimbal) photo.attitude = Gimbal(k);
      photos.push_back(photo);
    }
  }
  static bench::FlightPlan Plan() {
    bench::FlightPlan plan;
    plan.legs = 2;
    plan.leg_m = 120.0;
    return plan;
  }
  // A gimbal that looks forward and down, 60 degrees below the horizon, with the airframe's yaw error in its
  // yaw.
  flight::RecordedAttitude Gimbal(std::size_t k) const {
    const Vector3d nose = sensors.photo_attitudes[k].enu_from_body * Vector3d::UnitX();
    return {.yaw_rad = std::atan2(nose.x(), nose.y()), .pitch_rad = -1.047, .source = ""};
  }
  Quaterniond TrueGimbal(std::size_t k) const {
    const Vector3d nose = flight.At(flight.photo_times_s()[k]).enu_from_body * Vector3d::UnitX();
    return CamFromEnu({.yaw_rad = std::atan2(nose.x(), nose.y()), .pitch_rad = -1.047, .source = ""});
  }
  Quaterniond TrueFixed(std::size_t k) const {  // to the airframe
    return CamFromBody() * flight.At(flight.photo_times_s()[k]).enu_from_body.conjugate();
  }
  FlightSources Sources(bool with_log) const {
    FlightSources sources;
    for (std::size_t k = 0; k < photos.size(); ++k) {
      sources.photos.push_back(
          {&photos[k], flight.photo_times_s()[k], 0.0, sensors.photo_heights[k].z_in_enu_m});
    }
    if (with_log) sources.log = &log;
    return sources;
  }
};

struct Errors {
  double position_m = 0.0;  // RMS, horizontal
  double rotation_rad = 0.0;
  double stated_position_m = 0.0;
  double stated_rotation_rad = 0.0;
};

Errors Compare(const Recorded& recorded, const std::vector<PosedPhoto>& cameras,
               Quaterniond (Recorded::*true_cam)(std::size_t) const) {
  Errors errors;
  const double n = static_cast<double>(cameras.size());
  for (std::size_t k = 0; k < cameras.size(); ++k) {
    const Vector3d truth = recorded.flight.At(recorded.flight.photo_times_s()[k]).position;
    errors.position_m += (cameras[k].cam_from_enu.TargetOriginInSource() - truth).head<2>().squaredNorm() / n;
    errors.rotation_rad +=
        std::pow(cameras[k].cam_from_enu.rotation.angularDistance((recorded.*true_cam)(k)), 2) / n;
    errors.stated_position_m += cameras[k].covariance.diagonal().segment<2>(3).sum() / n;
    errors.stated_rotation_rad += cameras[k].covariance.diagonal().head<3>().sum() / n;
  }
  return {std::sqrt(errors.position_m), std::sqrt(errors.rotation_rad), std::sqrt(errors.stated_position_m),
          std::sqrt(errors.stated_rotation_rad)};
}

std::vector<PosedPhoto> Place(const PreparedSmoothing& prepared) {
  const auto smoothed = SmoothChain(prepared.input);
  EXPECT_TRUE(smoothed.ok()) << smoothed.error().message;
  return PlaceCameras(prepared, *smoothed, 0.0);
}

TEST(SmootherInput, PlacesPhotosByTheirXmpAlone) {
  const Recorded recorded(1, true);
  const PreparedSmoothing prepared = MakeSmootherInput(recorded.Sources(false), Frame());
  EXPECT_TRUE(prepared.is_placed);
  const std::vector<PosedPhoto> cameras = Place(prepared);
  ASSERT_EQ(cameras.size(), recorded.photos.size());
  const Errors errors = Compare(recorded, cameras, &Recorded::TrueGimbal);
  EXPECT_LT(errors.position_m, 4.0);
  EXPECT_LT(errors.rotation_rad, 0.12);
  EXPECT_LT(errors.position_m, 3.0 * errors.stated_position_m);
  EXPECT_LT(errors.rotation_rad, 3.0 * errors.stated_rotation_rad);
  EXPECT_EQ(cameras[0].attitude_origin, AttitudeOrigin::kRecorded);
  for (const PosedPhoto& c : cameras) {
    EXPECT_GT(c.error_radius_m, 0.3);
    EXPECT_LT(c.error_radius_m, 10.0);
  }
}

TEST(SmootherInput, TurnsPhotosWithoutAnglesAlongTheirCourse) {
  const Recorded recorded(2);
  const PreparedSmoothing prepared = MakeSmootherInput(recorded.Sources(false), Frame());
  EXPECT_TRUE(prepared.input.options.yaw_from_course);
  const std::vector<PosedPhoto> cameras = Place(prepared);
  EXPECT_EQ(cameras[0].attitude_origin, AttitudeOrigin::kCourse);
  const Errors errors = Compare(recorded, cameras, &Recorded::TrueFixed);
  EXPECT_LT(errors.rotation_rad, 0.5);
  EXPECT_LT(errors.rotation_rad, 3.0 * errors.stated_rotation_rad);
}

TEST(SmootherInput, UsesALogForACameraFixedToTheAirframe) {
  const Recorded recorded(3);
  PreparedSmoothing prepared = MakeSmootherInput(recorded.Sources(true), Frame());
  EXPECT_GT(prepared.input.options.boresight_sigma_rad, 0.04);
  const std::vector<PosedPhoto> cameras = Place(prepared);
  const Errors errors = Compare(recorded, cameras, &Recorded::TrueFixed);
  EXPECT_LT(errors.position_m, 4.0);
  EXPECT_LT(errors.rotation_rad, 0.01);
  // The mount is not known to better than its prior, and the errors say so.
  EXPECT_GT(errors.stated_rotation_rad, 0.05);
}

TEST(SmootherInput, TakesTheSlowErrorOfTheAirframeOutOfTheGimbal) {
  const Recorded recorded(4, true);
  const PreparedSmoothing prepared = MakeSmootherInput(recorded.Sources(true), Frame());
  ASSERT_TRUE(prepared.recorded_enu_from_cam[0].has_value());
  const std::vector<PosedPhoto> cameras = Place(prepared);
  double recorded_error = 0.0;
  for (std::size_t k = 0; k < cameras.size(); ++k) {
    recorded_error +=
        std::pow(CamFromEnu(*recorded.photos[k].attitude).angularDistance(recorded.TrueGimbal(k)), 2);
  }
  recorded_error = std::sqrt(recorded_error / static_cast<double>(cameras.size()));
  EXPECT_LT(Compare(recorded, cameras, &Recorded::TrueGimbal).rotation_rad, 0.7 * recorded_error);
}

// The same flight without any position, to be reckoned from where it started.
FlightSources WithoutPositions(Recorded& recorded) {
  recorded.log.gnss.clear();
  for (flight::Photo& p : recorded.photos) p.position.reset();
  FlightSources sources = recorded.Sources(true);
  for (PhotoAtTime& p : sources.photos) p.height_above_ground_m.reset();
  sources.start_in_enu_m = recorded.flight.At(0.0).position;
  return sources;
}

TEST(SmootherInput, ReckonsFromTheStartPointWithoutAnyPosition) {
  Recorded recorded(5);
  const FlightSources sources = WithoutPositions(recorded);
  const PreparedSmoothing prepared = MakeSmootherInput(sources, Frame());
  EXPECT_FALSE(prepared.is_placed);
  ASSERT_FALSE(prepared.input.still.empty());
  EXPECT_NEAR(prepared.input.still.front().begin_s, 0.0, 1.1);
  const std::vector<PosedPhoto> cameras = Place(prepared);
  const Errors errors = Compare(recorded, cameras, &Recorded::TrueFixed);
  EXPECT_LT(errors.position_m, 60.0);
  EXPECT_LT(errors.position_m, 3.0 * errors.stated_position_m);
  EXPECT_GT(cameras.back().error_radius_m, cameras.front().error_radius_m);
}

// Nobody says where it landed; that it stands there is in the record.
TEST(SmootherInput, StandingAfterTheLandingTakesDriftAway) {
  double with_rest_m = 0.0, without_rest_m = 0.0, stated_m = 0.0;
  for (std::uint64_t seed = 5; seed < 9; ++seed) {
    Recorded recorded(seed);
    for (flight::Photo& p : recorded.photos) p.velocity_in_enu_mps.reset();
    const FlightSources sources = WithoutPositions(recorded);
    const PreparedSmoothing landed = MakeSmootherInput(sources, Frame());
    ASSERT_EQ(landed.input.still.size(), 2u);
    EXPECT_GT(landed.input.still[1].begin_s, recorded.flight.landed_s());
    const Errors better = Compare(recorded, Place(landed), &Recorded::TrueFixed);
    std::erase_if(recorded.log.imu,
                  [&](const flight::ImuSample& s) { return s.t_s > recorded.flight.landed_s(); });
    const PreparedSmoothing cut = MakeSmootherInput(sources, Frame());
    ASSERT_EQ(cut.input.still.size(), 1u);
    const Errors worse = Compare(recorded, Place(cut), &Recorded::TrueFixed);
    EXPECT_LT(better.stated_position_m, 0.8 * worse.stated_position_m);
    with_rest_m += better.position_m;
    without_rest_m += worse.position_m;
    stated_m += better.stated_position_m;
  }
  EXPECT_LT(with_rest_m, 0.8 * without_rest_m);
  EXPECT_LT(with_rest_m, 2.0 * stated_m);
}

TEST(RecordedSeries, JudgesTheNoiseOfInertialSamples) {
  const Recorded recorded(6);
  const auto noise = JudgeImu(recorded.log.imu);
  ASSERT_TRUE(noise.has_value());
  // Gusts and turns leave a little in the second differences; more than truth is safe, less is not.
  EXPECT_GT(noise->accel_white, 1.8e-3);
  EXPECT_LT(noise->accel_white, 3.0e-3);
  EXPECT_GT(noise->gyro_white, 6.0e-5);
  EXPECT_LT(noise->gyro_white, 3.0e-4);
  std::vector<flight::ImuSample> slow;
  for (std::size_t k = 0; k < recorded.log.imu.size(); k += 25) slow.push_back(recorded.log.imu[k]);
  EXPECT_FALSE(JudgeImu(slow).has_value());
}

TEST(RecordedSeries, DropsTheRangeFindersLimit) {
  std::vector<flight::RangeSample> samples;
  for (int k = 0; k < 100; ++k) samples.push_back({0.5 * k, k < 60 ? 0.4 * k : 25.0});
  const std::vector<RangeFix> fixes = RangesOfLog(samples);
  EXPECT_GT(fixes.size(), 50u);
  for (const RangeFix& f : fixes) EXPECT_LT(f.distance_m, 24.8);
}

TEST(RecordedSeries, TakesRtkAtItsWordAndFloatAtItsOwn) {
  std::vector<flight::GnssSample> samples;
  for (int k = 0; k < 50; ++k) {
    flight::GnssSample s;
    s.t_s = k;
    s.position = {47.4, 8.5};
    s.height_ellipsoid_m = 500.0;
    s.sigma_horizontal_m = k % 5 == 0 ? 0.4 : 0.015;
    s.is_rtk_fixed = k % 5 != 0;
    samples.push_back(s);
  }
  const GnssSeries series = GnssOfLog(samples, Frame());
  EXPECT_TRUE(series.is_rtk);
  EXPECT_NEAR(series.bias_sigma_m.x(), 0.01, 1e-6);
  EXPECT_GT(series.positions[0].sigma_m.x(), 0.3);
  EXPECT_LT(series.positions[1].sigma_m.x(), 0.01);
  EXPECT_NEAR(series.positions[1].position_in_enu_m.z(), 50.0, 1e-6);
}

// A survey of two days with their logs: one chain of both had knots for all the time between them.
TEST(PlaceByLog, SmoothsFlightsDaysApartEachByItself) {
  const Recorded recorded(3);
  static constexpr double kThreeDaysS = 3.0 * 86400.0;
  flight::FlightLog log = recorded.log, later = recorded.log;
  const auto append = [](auto& into, const auto& more) {
    for (auto sample : more) {
      sample.t_s += kThreeDaysS;
      into.push_back(sample);
    }
  };
  flight::ForEachSeries(append, log, later);
  FlightSources sources = recorded.Sources(true);
  const PlacedByLog one = test::ValueOf(PlaceByLog(sources, Frame(), 0.0));
  const std::size_t count = sources.photos.size();
  for (std::size_t k = 0; k < count; ++k) {
    PhotoAtTime again = sources.photos[k];
    again.t_s += kThreeDaysS;
    sources.photos.push_back(again);
  }
  sources.log = &log;
  const PlacedByLog both = test::ValueOf(PlaceByLog(sources, Frame(), 0.0));
  ASSERT_EQ(both.photos.size(), 2 * count);
  EXPECT_NEAR(both.smoothing.knots, 2 * one.smoothing.knots, 20);
  EXPECT_EQ(both.series, one.series);
  EXPECT_TRUE(both.is_placed);
  for (std::size_t k = 0; k < count; ++k) {
    const Vector3d center = one.photos[k].cam_from_enu.TargetOriginInSource();
    EXPECT_EQ(both.photos[k].cam_from_enu.TargetOriginInSource(), center) << k;
    const Vector3d again = both.photos[count + k].cam_from_enu.TargetOriginInSource();
    EXPECT_LT((again - center).head<2>().norm(), 0.5) << k;
  }
}

}  // namespace
}  // namespace skyquilt::poses
