// The log writers, read back by the product's own parsers: two independent readings of each format.
#include "core/simulate/writers/write_logs.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/check.h"
#include "core/flight/logs/formats.h"
#include "core/flight/remarks/remark_words.h"
#include "tests/core/simulate/surveys.h"
#include "tests/support/value_of.h"

namespace skyquilt::simulate {
namespace {

const flight::FlightLog& Log() {
  static const flight::FlightLog log = [] {
    SurveyOptions options = ReferenceSurvey(1);
    options.sensors.has_range = true;
    auto survey = FlySurvey(options, ReferenceCamera(), geo::LocalFrame({-33.4, -70.6, 540.0}),
                            flight::UtcTime(std::chrono::microseconds(1717236000123456)));
    SKYQUILT_CHECK(survey.ok(), "the reference survey can be flown");
    return survey->log;
  }();
  return log;
}

struct Tolerance {
  double time_s = 1.1e-6, rate = 1e-6, force = 1e-5, angle_rad = 1e-5, degrees = 1e-9, height_m = 1e-3,
         speed = 1e-3;
  double clock_s = 2e-3;
  bool has_ellipsoid = true;
};

void ExpectSame(const flight::FlightLog& read, const flight::FlightLog& truth, const Tolerance& tolerance) {
  ASSERT_EQ(read.imu.size(), truth.imu.size());
  for (std::size_t i = 0; i < truth.imu.size(); i += 97) {
    EXPECT_NEAR(read.imu[i].t_s, truth.imu[i].t_s, tolerance.time_s);
    EXPECT_LT((read.imu[i].angular_rate_radps - truth.imu[i].angular_rate_radps).norm(), tolerance.rate);
    EXPECT_LT((read.imu[i].specific_force_mps2 - truth.imu[i].specific_force_mps2).norm(), tolerance.force);
  }
  ASSERT_EQ(read.attitude.size(), truth.attitude.size());
  for (std::size_t i = 0; i < truth.attitude.size(); i += 13) {
    EXPECT_LT(read.attitude[i].ned_from_body.angularDistance(truth.attitude[i].ned_from_body),
              tolerance.angle_rad);
  }
  ASSERT_EQ(read.gnss.size(), truth.gnss.size());
  for (std::size_t i = 0; i < truth.gnss.size(); i += 7) {
    const flight::GnssSample& a = read.gnss[i];
    const flight::GnssSample& b = truth.gnss[i];
    EXPECT_NEAR(a.t_s, b.t_s, tolerance.time_s);
    EXPECT_NEAR(a.position.lat_deg, b.position.lat_deg, tolerance.degrees);
    EXPECT_NEAR(a.position.lon_deg, b.position.lon_deg, tolerance.degrees);
    if (tolerance.has_ellipsoid) {
      ASSERT_TRUE(a.height_ellipsoid_m.has_value());
      EXPECT_NEAR(*a.height_ellipsoid_m, *b.height_ellipsoid_m, tolerance.height_m);
    } else if (b.height_amsl_m) {
      ASSERT_TRUE(a.height_amsl_m.has_value());
      EXPECT_NEAR(*a.height_amsl_m, *b.height_amsl_m, tolerance.height_m);
    }
    ASSERT_TRUE(a.velocity_in_ned_mps.has_value());
    EXPECT_LT((*a.velocity_in_ned_mps - *b.velocity_in_ned_mps).norm(), tolerance.speed);
    ASSERT_TRUE(a.sigma_horizontal_m.has_value());
    EXPECT_NEAR(*a.sigma_horizontal_m, *b.sigma_horizontal_m, 0.006);
  }
  ASSERT_EQ(read.baro.size(), truth.baro.size());
  const double zero_m = read.baro[0].height_above_takeoff_m - truth.baro[0].height_above_takeoff_m;
  for (std::size_t i = 0; i < truth.baro.size(); i += 11) {
    EXPECT_NEAR(read.baro[i].height_above_takeoff_m - truth.baro[i].height_above_takeoff_m, zero_m, 1e-3);
  }
  EXPECT_LT(std::abs(zero_m), 0.5);
  ASSERT_EQ(read.range.size(), truth.range.size());
  for (std::size_t i = 0; i < truth.range.size(); ++i) {
    EXPECT_NEAR(read.range[i].distance_m, truth.range[i].distance_m, 0.0051);
  }
  ASSERT_EQ(read.events.size(), truth.events.size());
  for (std::size_t i = 0; i < truth.events.size(); ++i) {
    EXPECT_NEAR(read.events[i].t_s, truth.events[i].t_s, tolerance.time_s);
    EXPECT_TRUE(read.events[i].is_feedback);
  }
  ASSERT_TRUE(read.utc_at_zero.has_value());
  EXPECT_LT(std::abs(std::chrono::duration<double>(*read.utc_at_zero - *truth.utc_at_zero).count()),
            tolerance.clock_s);
  EXPECT_TRUE(read.warnings.empty()) << InWords(read.warnings.front());
}

TEST(WriteDataflash, IsReadBackByTheParser) {
  const auto read = test::ValueOf(flight::ParseDataflash("flight.BIN", DataflashBytes(Log())));
  Tolerance tolerance;
  tolerance.angle_rad = 3e-4;
  tolerance.degrees = 6e-8;
  tolerance.height_m = 0.006;
  tolerance.has_ellipsoid = false;
  ExpectSame(read, Log(), tolerance);
}

TEST(WriteUlog, IsReadBackByTheParser) {
  const auto read = test::ValueOf(flight::ParseUlog("flight.ulg", UlogBytes(Log())));
  ExpectSame(read, Log(), {});
}

TEST(WriteCsv, IsReadBackByTheParser) {
  const std::string text = FlightCsv(Log());
  const auto read = test::ValueOf(flight::ParseFlightCsv("flight.csv", flight::BytesOf(text)));
  flight::FlightLog from_zero = Log();
  ExpectSame(read, from_zero, {});
}

TEST(WriteDataflash, WithoutFeedbackTheEventsAreCommands) {
  flight::FlightLog log = Log();
  log.imu.clear();
  for (flight::CameraEvent& event : log.events) event.is_feedback = false;
  const auto read = test::ValueOf(flight::ParseDataflash("flight.BIN", DataflashBytes(log)));
  ASSERT_EQ(read.events.size(), log.events.size());
  EXPECT_FALSE(read.events[3].is_feedback);
  const auto ulog = test::ValueOf(flight::ParseUlog("flight.ulg", UlogBytes(log)));
  ASSERT_EQ(ulog.events.size(), log.events.size());
  EXPECT_FALSE(ulog.events[3].is_feedback);
}

}  // namespace
}  // namespace skyquilt::simulate
