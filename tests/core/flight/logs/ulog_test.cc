#include <gtest/gtest.h>

#include "core/flight/bytes/gps_time.h"
#include "core/flight/logs/formats.h"
#include "core/flight/logs/log_builder.h"
#include "core/flight/remarks/remark_words.h"
#include "tests/core/flight/logs/log_writers.h"
#include "tests/support/value_of.h"

namespace skyquilt::flight {
namespace {

using test::ValueOf;
using testing::Append;
using testing::Bytes;
using testing::UlogWriter;

template <typename... Values>
Bytes Pack(std::uint64_t timestamp, Values... values) {
  Bytes bytes;
  Append(bytes, timestamp);
  (Append(bytes, values), ...);
  return bytes;
}

void DefineTopics(UlogWriter& w) {
  w.Define("nested:uint16_t a;uint8_t b;");
  w.Define(
      "sensor_combined:uint64_t timestamp;nested[2] before;float[3] gyro_rad;uint32_t gyro_integral_dt;"
      "float[3] accelerometer_m_s2;uint8_t[3] _padding0;");
  w.Define("vehicle_attitude:uint64_t timestamp;uint64_t timestamp_sample;float[4] q;");
  w.Define(
      "vehicle_gps_position:uint64_t timestamp;uint64_t time_utc_usec;int32_t lat;int32_t lon;int32_t alt;"
      "int32_t alt_ellipsoid;float eph;float epv;float vel_n_m_s;float vel_e_m_s;float vel_d_m_s;uint8_t "
      "fix_type;"
      "bool vel_ned_valid;");
  w.Define(
      "sensor_gps:uint64_t timestamp;double latitude_deg;double longitude_deg;double altitude_msl_m;"
      "double altitude_ellipsoid_m;uint64_t time_utc_usec;float eph;float epv;uint8_t fix_type;");
  w.Define("vehicle_air_data:uint64_t timestamp;float baro_alt_meter;");
  w.Define(
      "distance_sensor:uint64_t timestamp;float min_distance;float max_distance;float current_distance;"
      "uint8_t orientation;");
  w.Define(
      "camera_capture:uint64_t timestamp;uint64_t timestamp_utc;uint32_t seq;double lat;double lon;float alt;"
      "float ground_distance;float[4] q;int8_t result;uint8_t[7] _padding0;");
}

constexpr std::uint64_t kUtcUs = 1'700'000'000'000'000;

Bytes FlightLogBytes(bool with_camera, bool old_gps) {
  UlogWriter w;
  DefineTopics(w);
  w.Subscribe(0, "sensor_combined");
  w.Subscribe(1, "vehicle_attitude");
  w.Subscribe(2, old_gps ? "vehicle_gps_position" : "sensor_gps");
  w.Subscribe(3, "vehicle_air_data");
  w.Subscribe(4, "distance_sensor");
  w.Subscribe(5, "camera_capture");
  w.Subscribe(6, "vehicle_air_data", 1);
  for (int i = 0; i < 1000; ++i) {
    const std::uint64_t us = 10'000'000 + static_cast<std::uint64_t>(i) * 4000;
    Bytes imu = Pack(us, std::uint16_t{1}, std::uint8_t{2}, std::uint16_t{3}, std::uint8_t{4}, 0.1f, 0.2f,
                     0.3f, std::uint32_t{4000}, 1.0f, 2.0f, -9.75f);
    w.Data(0, imu);  // trailing padding is not written
    if (i % 10 == 0) w.Data(1, Pack(us + 500, us, 0.70710678f, 0.0f, 0.0f, 0.70710678f));
    if (i % 50 == 0) {
      const std::uint64_t utc = kUtcUs + us;
      if (old_gps) {
        w.Data(2, Pack(us, utc, 475'000'000, 85'000'000, 500'250, 548'250, 1.5f, 2.5f, 1.0f, 2.0f, -0.5f,
                       std::uint8_t{3}, std::uint8_t{1}));
      } else {
        w.Data(2, Pack(us, 47.5, 8.5, 500.25, 548.25, utc, 1.5f, 2.5f, std::uint8_t{6}));
      }
      w.Data(3, Pack(us, 480.0f + 0.01f * static_cast<float>(i)));
      w.Data(6, Pack(us, 9999.0f));
      w.Data(4, Pack(us, 0.2f, 40.0f, 12.5f, std::uint8_t{25}));
      w.Data(4, Pack(us + 1000, 0.2f, 40.0f, 3.5f, std::uint8_t{0}));  // looks forward
    }
    if (with_camera && i % 200 == 100) {
      w.Data(5, Pack(us, kUtcUs + us, static_cast<std::uint32_t>(i / 200), 47.5, 8.5, 560.0f, 60.0f, 0.5f,
                     0.5f, -0.5f, 0.5f, std::int8_t{1}));
    }
    if (i == 500) w.Dropout(37);
  }
  return w.bytes();
}

void ExpectTheFlight(const FlightLog& log) {
  ASSERT_EQ(log.imu.size(), 1000u);
  EXPECT_DOUBLE_EQ(log.imu[1].t_s, 10.004);
  EXPECT_NEAR(log.imu[1].angular_rate_radps.z(), 0.3, 1e-7);
  EXPECT_NEAR(log.imu[1].specific_force_mps2.z(), -9.75, 1e-7) << "behind nested fields";
  ASSERT_EQ(log.attitude.size(), 100u);
  EXPECT_DOUBLE_EQ(log.attitude[0].t_s, 10.0) << "the time of measurement, not of publication";
  EXPECT_NEAR(YawPitchRollFromNed(log.attitude[0].ned_from_body)[0], geo::DegToRad(90.0), 1e-6);
  ASSERT_EQ(log.gnss.size(), 20u);
  EXPECT_NEAR(log.gnss[0].position.lat_deg, 47.5, 1e-9);
  EXPECT_NEAR(log.gnss[0].position.lon_deg, 8.5, 1e-9);
  EXPECT_NEAR(*log.gnss[0].height_amsl_m, 500.25, 1e-9);
  EXPECT_NEAR(*log.gnss[0].height_ellipsoid_m, 548.25, 1e-9);
  EXPECT_DOUBLE_EQ(*log.gnss[0].sigma_horizontal_m, 1.5);
  ASSERT_EQ(log.baro.size(), 20u);
  EXPECT_NEAR(log.baro.back().height_above_takeoff_m - log.baro.front().height_above_takeoff_m, 9.5, 1e-3);
  EXPECT_LT(std::abs(log.baro.front().height_above_takeoff_m), 5.0)
      << "counted from the start, not from the sea";
  ASSERT_EQ(log.range.size(), 20u);
  EXPECT_DOUBLE_EQ(log.range[0].distance_m, 12.5);
  ASSERT_TRUE(log.utc_at_zero.has_value());
  EXPECT_EQ(log.utc_at_zero->time_since_epoch().count(), static_cast<std::int64_t>(kUtcUs));
}

TEST(ParseUlog, ReadsIntegerAndDoublePositionsAlike) {
  const auto old_names = ValueOf(ParseUlog("old.ulg", FlightLogBytes(false, true)));
  ExpectTheFlight(old_names);
  EXPECT_NEAR(old_names.gnss.at(0).velocity_in_ned_mps->y(), 2.0, 1e-7);
  EXPECT_FALSE(old_names.gnss.at(0).is_rtk_fixed);
  const auto new_names = ValueOf(ParseUlog("new.ulg", FlightLogBytes(false, false)));
  ExpectTheFlight(new_names);
  EXPECT_TRUE(new_names.gnss.at(0).is_rtk_fixed);
}

TEST(ParseUlog, ReadsCameraCaptures) {
  const auto log = ValueOf(ParseUlog("camera.ulg", FlightLogBytes(true, true)));
  ASSERT_EQ(log.events.size(), 5u);
  const CameraEvent& event = log.events[2];
  EXPECT_TRUE(event.is_feedback);
  EXPECT_EQ(*event.sequence, 2);
  EXPECT_NEAR(event.t_s, 12.0, 1e-9);
  EXPECT_NEAR(event.position->lat_deg, 47.5, 1e-12);
  EXPECT_DOUBLE_EQ(*event.height_above_ground_m, 60.0);
  // q turns the camera's axis straight down.
  EXPECT_NEAR((*event.yaw_pitch_roll_rad)[1], geo::DegToRad(-90.0), 1e-3);
  EXPECT_EQ(event.attitude_kind, AttitudeKind::kGimbal);
}

TEST(ParseUlog, TellsAGimbalForAllPhotosOfALog) {
  const auto kinds_of = [](const std::vector<double>& pitches_deg) {
    UlogWriter w;
    DefineTopics(w);
    w.Subscribe(0, "camera_capture");
    std::uint64_t us = 10'000'000;
    for (const double pitch_deg : pitches_deg) {
      const Eigen::Quaterniond q = NedFromYawPitchRoll(0.5, geo::DegToRad(pitch_deg), 0.0);
      w.Data(0, Pack(us, kUtcUs + us, std::uint32_t{1}, 47.5, 8.5, 560.0f, 60.0f, static_cast<float>(q.w()),
                     static_cast<float>(q.x()), static_cast<float>(q.y()), static_cast<float>(q.z()),
                     std::int8_t{1}));
      us += 1'000'000;
    }
    const auto log = ValueOf(ParseUlog("camera.ulg", w.bytes()));
    std::vector<AttitudeKind> kinds;
    for (const CameraEvent& event : log.events) kinds.push_back(event.attitude_kind);
    return kinds;
  };
  EXPECT_EQ(kinds_of({-90.0, -30.0, -30.0}), std::vector<AttitudeKind>(3, AttitudeKind::kGimbal));
  std::vector<double> of_airframe(20, -5.0);
  EXPECT_EQ(kinds_of(of_airframe), std::vector<AttitudeKind>(20, AttitudeKind::kAirframe));
  of_airframe.push_back(-60.0);  // where it falls
  EXPECT_EQ(kinds_of(of_airframe).front(), AttitudeKind::kAirframe);
}

TEST(ParseUlog, ReadsHowAGimbalHoldsItsCamera) {
  UlogWriter w;
  DefineTopics(w);
  w.Define(
      "gimbal_device_attitude_status:uint64_t timestamp;float[4] q;uint32_t failure_flags;"
      "uint16_t device_flags;uint8_t target_system;bool received_from_mavlink;");
  w.Subscribe(0, "vehicle_attitude");
  w.Subscribe(1, "gimbal_device_attitude_status");
  const Eigen::Quaterniond q = NedFromYawPitchRoll(0.5, -1.0, 0.0);
  for (std::uint64_t i = 0; i < 10; ++i) {
    const std::uint64_t us = 10'000'000 + i * 100'000;
    w.Data(0, Pack(us, us, 0.70710678f, 0.0f, 0.0f, 0.70710678f));
    w.Data(1, Pack(us, static_cast<float>(q.w()), static_cast<float>(q.x()), static_cast<float>(q.y()),
                   static_cast<float>(q.z()), std::uint32_t{0}, std::uint16_t{32}, std::uint8_t{1},
                   std::uint8_t{1}));
    // What servos are told to do.
    w.Data(1, Pack(us + 50'000, 1.0f, 0.0f, 0.0f, 0.0f, std::uint32_t{0}, std::uint16_t{0}, std::uint8_t{1},
                   std::uint8_t{0}));
  }
  const auto log = ValueOf(ParseUlog("gimbal.ulg", w.bytes()));
  ASSERT_EQ(log.gimbal.size(), 10u);
  EXPECT_NEAR(log.gimbal[1].t_s, 10.1, 1e-9);
  const auto expected = NedFromYawPitchRoll(geo::DegToRad(90.0) + 0.5, -1.0, 0.0);
  EXPECT_LT(expected.angularDistance(log.gimbal[1].ned_from_body), 1e-5);
}

TEST(ParseUlog, CountsEveryTopicAndTheDropouts) {
  const auto log = ValueOf(ParseUlog("flight.ulg", FlightLogBytes(true, true)));
  EXPECT_EQ(log.message_counts.at("sensor_combined"), 1000u);
  EXPECT_EQ(log.message_counts.at("vehicle_air_data[1]"), 20u);
  EXPECT_EQ(log.message_counts.at("camera_capture"), 5u);
  ASSERT_FALSE(log.warnings.empty());
  EXPECT_NE(InWords(log.warnings[0]).find("0.037 s"), std::string::npos);
}

TEST(ParseUlog, ReadsASectionAppendedAfterACutOne) {
  // The main section ends inside a message; the flags say where the appended data starts.
  const auto build = [](std::uint64_t appended_at) {
    UlogWriter w(true, appended_at);
    DefineTopics(w);
    w.Subscribe(3, "vehicle_air_data");
    for (std::uint64_t i = 0; i < 10; ++i)
      w.Data(3, Pack(1'000'000 + i * 100'000, 1.0f * static_cast<float>(i)));
    w.bytes().resize(w.bytes().size() - 5);
    const std::uint64_t at = w.bytes().size();
    for (std::uint64_t i = 10; i < 15; ++i)
      w.Data(3, Pack(1'000'000 + i * 100'000, 1.0f * static_cast<float>(i)));
    return std::make_pair(w.bytes(), at);
  };
  const auto [bytes, ignored] = build(build(1).second);
  const auto log = ValueOf(ParseUlog("appended.ulg", bytes));
  EXPECT_EQ(log.baro.size(), 14u) << "all but the one that was cut";
  EXPECT_NEAR(log.baro.back().t_s, 2.4, 1e-9);
}

TEST(ParseUlog, GoesOnAfterDamage) {
  Bytes bytes = FlightLogBytes(false, true);
  for (std::size_t i = bytes.size() / 2; i < bytes.size() / 2 + 300; ++i) bytes[i] = 0xFF;
  const auto log = ValueOf(ParseUlog("damaged.ulg", bytes));
  EXPECT_GT(log.imu.size(), 980u);
  EXPECT_LT(log.imu.size(), 1000u);
}

TEST(ParseUlog, RefusesHostileTypeDefinitions) {
  UlogWriter w;
  w.Define("loop:uint64_t timestamp;loop[4] again;float baro_alt_meter;");
  w.Define("huge:uint64_t timestamp;uint8_t[60000] a;uint8_t[60000] b;float baro_alt_meter;");
  std::string wide = "w0:";
  for (int level = 0; level < 7; ++level) {
    std::string definition = "w" + std::to_string(level) + ":";
    for (int i = 0; i < 500; ++i) definition += "w" + std::to_string(level + 1) + "[0] m;";
    w.Define(definition);
  }
  w.Define("vehicle_air_data:uint64_t timestamp;w0 deep;float baro_alt_meter;");
  w.Subscribe(0, "loop");
  w.Subscribe(1, "huge");
  w.Subscribe(2, "vehicle_air_data");
  w.Data(2, Pack(1'000'000, 5.0f));
  EXPECT_TRUE(ValueOf(ParseUlog("hostile.ulg", w.bytes())).baro.empty());
}

}  // namespace
}  // namespace skyquilt::flight
