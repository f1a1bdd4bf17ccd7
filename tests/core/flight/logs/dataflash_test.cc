#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>

#include "core/flight/bytes/gps_time.h"
#include "core/flight/logs/autopilots/dataflash_walk.h"
#include "core/flight/logs/formats.h"
#include "core/flight/logs/log_builder.h"
#include "core/flight/logs/read_log.h"
#include "core/flight/remarks/remark_words.h"
#include "tests/core/flight/logs/log_writers.h"
#include "tests/support/value_of.h"

namespace skyquilt::flight {
namespace {

using geo::DegToRad;
using test::ErrorOf;
using test::ValueOf;
using testing::Bytes;
using testing::DataflashWriter;

// As Mission Planner writes what it converted: "GPS, 5000000, 0, 6, ...".
class TextWriter {
 public:
  void Define(std::uint8_t type, std::string_view name, std::string_view format, std::string_view labels) {
    names_[type] = name;
    fields_[type] = format.size();
    text_ += fmt::format("FMT, {}, 89, {}, {}, {}\r\n", type, name, format, labels);
  }
  void Write(std::uint8_t type, std::initializer_list<double> values) {
    text_ += names_.at(type);
    for (const double value : values) text_ += fmt::format(", {}", value);
    for (std::size_t i = values.size(); i < fields_.at(type); ++i) text_ += ", 0";
    text_ += "\r\n";
  }
  Bytes bytes() const { return Bytes(text_.begin(), text_.end()); }

 private:
  std::map<std::uint8_t, std::string> names_;
  std::map<std::uint8_t, std::size_t> fields_;
  std::string text_ = "FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns\r\n";
};

// A minute of the modern layout: two IMUs of which the first clips, RTK GPS with accuracies, CAM rows.
template <typename Writer = DataflashWriter>
Bytes ModernLog() {
  Writer w;
  w.Define(1, "IMU", "QBffffff", "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ");
  w.Define(2, "VIBE", "QBfffI", "TimeUS,IMU,VibeX,VibeY,VibeZ,Clip");
  w.Define(3, "GPS", "QBBIHBcLLeffff", "TimeUS,I,Status,GMS,GWk,NSats,HDop,Lat,Lng,Alt,Spd,GCrs,VZ,Yaw");
  w.Define(4, "GPA", "QBCCCC", "TimeUS,I,VDop,HAcc,VAcc,SAcc");
  w.Define(5, "ATT", "Qccccccee", "TimeUS,DesRoll,Roll,DesPitch,Pitch,DesYaw,Yaw,ErrRP,ErrYaw");
  w.Define(6, "BARO", "QBfff", "TimeUS,I,Alt,Press,Temp");
  w.Define(7, "RFND", "QBCBB", "TimeUS,Instance,Dist,Stat,Orient");
  w.Define(8, "CAM", "QBHIHLLeeefff", "TimeUS,I,Img,GPSTime,GPSWeek,Lat,Lng,Alt,RelAlt,GPSAlt,R,P,Y");
  w.Define(9, "TRIG", "QBHIHLLeeefff", "TimeUS,I,Img,GPSTime,GPSWeek,Lat,Lng,Alt,RelAlt,GPSAlt,R,P,Y");
  for (int i = 0; i < 600; ++i) {
    const double us = 5e6 + i * 1e5;
    w.Write(1, {us, 0, 9, 9, 9, 9, 9, 9});
    w.Write(1, {us, 1, 0.01, -0.02, 0.03, 0.1, -0.2, -9.8});
    if (i % 10 == 0) {
      w.Write(2, {us, 0, 1, 1, 1, static_cast<double>(i)});
      w.Write(2, {us, 1, 1, 1, 1, 0});
      w.Write(3, {us, 0, 6, 345'600'000.0 + i * 100, 2300, 18, 0.7, -27.5, 153.25 + i * 1e-6, 120.5, 5, 90,
                  -0.5, 0});
      w.Write(4, {us, 0, 1, 0.02, 0.04, 0.1});
      w.Write(5, {us, 0, -12.5, 0, 3.25, 0, 271.0});
      w.Write(6, {us, 0, 0.1 * i, 101000, 20});
      w.Write(7, {us, 0, 20.5, 4, 25});
      w.Write(7, {us, 0, 99.0, 1, 25});  // no data
    }
    if (i % 50 == 25) {
      w.Write(9, {us - 5e4, 0, i / 50.0, 0, 0, -27.5, 153.25, 150, 30, 150, 1, 2, 3});
      w.Write(8, {us, 0, i / 50.0, 0, 0, -27.5, 153.25, 150.25, 30.5, 150, -1.5, 2.5, 180});
    }
  }
  return w.bytes();
}

TEST(ParseDataflash, ReadsTheModernLayoutInSiUnits) {
  const Bytes bytes = ModernLog();
  ASSERT_TRUE(LooksLikeDataflash(bytes));
  const auto log = ValueOf(ParseDataflash("flight.BIN", bytes));
  ASSERT_EQ(log.imu.size(), 600u);
  EXPECT_NEAR(log.imu[10].specific_force_mps2.z(), -9.8, 1e-6) << "the IMU without clips";
  EXPECT_NEAR(log.imu[10].angular_rate_radps.y(), -0.02, 1e-8);
  EXPECT_DOUBLE_EQ(log.imu[10].t_s, 6.0);
  ASSERT_EQ(log.gnss.size(), 60u);
  const GnssSample& fix = log.gnss[1];
  EXPECT_NEAR(fix.position.lat_deg, -27.5, 1e-9);
  EXPECT_NEAR(fix.position.lon_deg, 153.25001, 1e-9);
  EXPECT_DOUBLE_EQ(*fix.height_amsl_m, 120.5);
  EXPECT_NEAR(fix.velocity_in_ned_mps->y(), 5.0, 1e-6);
  EXPECT_NEAR(fix.velocity_in_ned_mps->z(), -0.5, 1e-6);
  EXPECT_DOUBLE_EQ(*fix.sigma_horizontal_m, 0.02);
  EXPECT_DOUBLE_EQ(*fix.sigma_vertical_m, 0.04);
  EXPECT_TRUE(fix.is_rtk_fixed);
  ASSERT_EQ(log.attitude.size(), 60u);
  const auto expected = NedFromYawPitchRoll(DegToRad(271.0), DegToRad(3.25), DegToRad(-12.5));
  EXPECT_LT(expected.angularDistance(log.attitude[0].ned_from_body), 1e-9);
  EXPECT_NEAR(log.baro.at(1).height_above_takeoff_m, 1.0, 1e-6);
  ASSERT_EQ(log.range.size(), 60u);
  EXPECT_DOUBLE_EQ(log.range[0].distance_m, 20.5);
  EXPECT_EQ(log.message_counts.at("IMU"), 1200u);
  EXPECT_EQ(log.message_counts.at("FMT"), 10u);
}

TEST(ParseDataflash, TakesShutterRowsBeforeCommands) {
  const auto log = ValueOf(ParseDataflash("flight.BIN", ModernLog()));
  ASSERT_EQ(log.events.size(), 12u);
  const CameraEvent& event = log.events[1];
  EXPECT_TRUE(event.is_feedback);
  EXPECT_DOUBLE_EQ(event.t_s, 12.5);
  EXPECT_DOUBLE_EQ(*event.height_amsl_m, 150.25);
  EXPECT_DOUBLE_EQ(*event.height_above_takeoff_m, 30.5);
  EXPECT_NEAR((*event.yaw_pitch_roll_rad)[0], DegToRad(180.0), 1e-6);
  EXPECT_NEAR((*event.yaw_pitch_roll_rad)[2], DegToRad(-1.5), 1e-6);
}

TEST(ParseDataflash, KnowsUtcFromTheGpsWeekWithLeapSeconds) {
  const auto log = ValueOf(ParseDataflash("flight.BIN", ModernLog()));
  ASSERT_TRUE(log.utc_at_zero.has_value());
  // Week 2300 began on 2024-02-04; four days in, minus 18 leap seconds, minus the 5 s since boot.
  EXPECT_EQ(*log.utc_at_zero, *UtcFromCivil(2024, 2, 7, 23, 59, 37.0));
  EXPECT_GE(log.utc_sigma_s, 0.1);
}

TEST(ParseDataflash, ReadsTheOldLayout) {
  DataflashWriter w;
  w.Define(1, "IMU", "Iffffff", "TimeMS,GyrX,GyrY,GyrZ,AccX,AccY,AccZ");
  w.Define(2, "IMU2", "Iffffff", "TimeMS,GyrX,GyrY,GyrZ,AccX,AccY,AccZ");
  w.Define(3, "GPS", "BIHBcLLeeEefI", "Status,TimeMS,Week,NSats,HDop,Lat,Lng,RelAlt,Alt,Spd,GCrs,VZ,T");
  w.Define(4, "CAM", "IHLLeeccC", "GPSTime,GPSWeek,Lat,Lng,Alt,RelAlt,Roll,Pitch,Yaw");
  w.Define(5, "EKF1", "IccCffffffccc", "TimeMS,Roll,Pitch,Yaw,VN,VE,VD,PN,PE,PD,GX,GY,GZ");
  for (int i = 0; i < 100; ++i) {
    const double ms = 20'000 + i * 20;
    w.Write(1, {ms, 0.1, 0.2, 0.3, 0, 0, -9.8});
    w.Write(2, {ms, 0, 0, 0, 0, 0, -9.7});
    if (i % 10 == 0)
      w.Write(3, {3, 100'000 + ms, 1900, 9, 1.2, 10.0, 20.0, 15.5, 100.25, 4.0, 45.0, 0.25, ms});
    if (i == 50) w.Write(4, {100'000 + ms, 1900, 10.0, 20.0, 130, 30, 1, 2, 359});
    w.Write(5, {ms, 1.0, 2.0, 359.0, 0, 0, 0, 0, 0, 0, 0, 0, 0});
  }
  const auto log = ValueOf(ParseDataflash("old.bin", w.bytes()));
  ASSERT_EQ(log.imu.size(), 100u);
  EXPECT_NEAR(log.imu[0].angular_rate_radps.x(), 0.1, 1e-7);
  EXPECT_DOUBLE_EQ(log.imu[0].t_s, 20.0);
  ASSERT_EQ(log.gnss.size(), 10u);
  EXPECT_DOUBLE_EQ(log.gnss[0].t_s, 20.0);
  EXPECT_DOUBLE_EQ(*log.gnss[0].height_amsl_m, 100.25);
  EXPECT_NEAR(log.gnss[0].velocity_in_ned_mps->x(), 4.0 * std::cos(DegToRad(45.0)), 1e-6);
  ASSERT_EQ(log.events.size(), 1u);
  EXPECT_NEAR(log.events[0].t_s, 21.0, 1e-6) << "placed through GPS time: the row has no time since boot";
  EXPECT_FALSE(log.events[0].is_feedback);
  ASSERT_EQ(log.attitude.size(), 100u) << "the filter's attitude where ATT is absent";
}

TEST(ParseDataflash, PrefersRawSensorsWhereTheyWereLoggedFaster) {
  DataflashWriter w;
  w.Define(1, "IMU", "QBffffff", "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ");
  w.Define(2, "GYR", "QBQfff", "TimeUS,I,SampleUS,GyrX,GyrY,GyrZ");
  w.Define(3, "ACC", "QBQfff", "TimeUS,I,SampleUS,AccX,AccY,AccZ");
  for (int i = 0; i < 2000; ++i) {
    const double us = 1e6 + i * 1000.0;
    if (i % 20 == 0) w.Write(1, {us, 0, 9, 9, 9, 9, 9, 9});
    w.Write(3, {us + 900, 0, us, 0.001 * i, 0, -9.8});
    w.Write(2, {us + 950, 0, us + 500, 0.1, 0.2, 0.3});
  }
  const auto log = ValueOf(ParseDataflash("raw.bin", w.bytes()));
  ASSERT_EQ(log.imu.size(), 1999u);
  EXPECT_NEAR(log.imu[100].t_s, 1.1005, 1e-9) << "the time of the sample, not of its writing";
  EXPECT_NEAR(log.imu[100].specific_force_mps2.x(), 0.1005, 1e-6) << "between its neighbours";
  EXPECT_NEAR(log.imu[100].angular_rate_radps.z(), 0.3, 1e-6);
}

TEST(ParseDataflash, KeepsTheLongestPartWhenTheClockRestarts) {
  DataflashWriter w;
  w.Define(6, "BARO", "Qf", "TimeUS,Alt");
  for (int i = 0; i < 30; ++i) w.Write(6, {100e6 + i * 1e5, 1.0 * i});
  for (int i = 0; i < 200; ++i) w.Write(6, {2e6 + i * 1e5, 2.0 * i});
  const auto log = ValueOf(ParseDataflash("restart.bin", w.bytes()));
  ASSERT_EQ(log.baro.size(), 200u);
  EXPECT_NEAR(log.baro[0].t_s, 2.0, 1e-6);
  EXPECT_NEAR(log.baro[199].height_above_takeoff_m, 398.0, 1e-6);
  ASSERT_FALSE(log.warnings.empty());
}

TEST(ParseDataflash, DropsAStrayTimeStampAndContradictingDuplicates) {
  DataflashWriter w;
  w.Define(6, "BARO", "Qf", "TimeUS,Alt");
  for (int i = 0; i < 20; ++i) {
    w.Write(6, {1e6 + i * 1e5, 1.0 * i});
    if (i == 10) w.Write(6, {9e12, 5.0});
    if (i == 12) w.Write(6, {1e6 + i * 1e5, 1.0 * i});  // the same again: one is kept
    if (i == 15) w.Write(6, {1e6 + i * 1e5, 777.0});    // another value at the same time: neither is
  }
  const auto log = ValueOf(ParseDataflash("stray.bin", w.bytes()));
  EXPECT_EQ(log.baro.size(), 19u);
  for (const BaroSample& sample : log.baro) EXPECT_LT(sample.t_s, 10.0);
}

TEST(ParseDataflash, GoesOnAfterDamage) {
  Bytes bytes = ModernLog();
  for (std::size_t i = bytes.size() / 2; i < bytes.size() / 2 + 500; ++i) bytes[i] = 0x5A;
  const auto log = ValueOf(ParseDataflash("damaged.bin", bytes));
  EXPECT_GT(log.imu.size(), 580u);
  EXPECT_LT(log.imu.size(), 600u);
  EXPECT_NE(InWords(log.warnings.at(0)).find("damaged bytes"), std::string::npos);
}

TEST(ParseDataflashText, ReadsWhatTheLogHeldBeforeItWasConverted) {
  const Bytes text = ModernLog<TextWriter>();
  EXPECT_TRUE(LooksLikeDataflashText(text));
  EXPECT_FALSE(LooksLikeDataflash(text));
  EXPECT_FALSE(LooksLikeDataflashText(ModernLog()));
  const auto log = ParseLog("flight.log", text);
  const auto binary = ParseDataflash("flight.BIN", ModernLog());
  ASSERT_TRUE(log.ok() && binary.ok());
  EXPECT_EQ(log->message_counts, binary->message_counts);
  EXPECT_EQ(log->utc_at_zero, binary->utc_at_zero);
  ASSERT_EQ(log->imu.size(), binary->imu.size());
  EXPECT_NEAR(log->imu[10].angular_rate_radps.y(), -0.02, 1e-12);
  ASSERT_EQ(log->gnss.size(), binary->gnss.size());
  for (std::size_t i = 0; i < log->gnss.size(); ++i) {
    EXPECT_NEAR(log->gnss[i].position.lat_deg, binary->gnss[i].position.lat_deg, 1e-7);
    EXPECT_NEAR(log->gnss[i].position.lon_deg, binary->gnss[i].position.lon_deg, 1e-7);
    EXPECT_NEAR(*log->gnss[i].sigma_vertical_m, 0.04, 1e-9);
  }
  ASSERT_EQ(log->events.size(), binary->events.size());
  EXPECT_NEAR(*log->events[1].height_above_takeoff_m, 30.5, 1e-9);
  EXPECT_EQ(log->attitude.size(), binary->attitude.size());
  EXPECT_EQ(log->range.size(), binary->range.size());
  EXPECT_TRUE(log->warnings == binary->warnings);
}

TEST(ParseDataflashText, PassesOverHeadingsWordsAndWhatIsDamaged) {
  std::string text = "ArduCopter V3.2\r\nFree RAM: 4096\r\n\r\n";
  text += "FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns\n";
  text += "FMT, 6, 15, BARO, QfN, TimeUS,Alt,Name\nFMT, 999, 15, HUGE, Q, TimeUS\nFMT, 7\n";
  for (int i = 0; i < 20; ++i) text += fmt::format("BARO, {}, {}, two words\n", 1'000'000 + i * 100'000, i);
  text += "BARO, here, 5, x\nBARO, 3000000\nNONE, 1, 2\nBARO, 3100000, NaN, x\nBARO, 32";
  const auto log = ValueOf(ParseLog("flight.log", BytesOf(text)));
  EXPECT_EQ(log.baro.size(), 20u);
  EXPECT_EQ(log.message_counts.at("BARO"), 21u);
  std::vector<RemarkCode> codes;
  for (const Remark& warning : log.warnings) codes.push_back(warning.code);
  EXPECT_THAT(codes, ::testing::IsSupersetOf({RemarkCode::kBytesDamaged, RemarkCode::kCutInMessage}));
}

TEST(ParseDataflashText, TakesTheLastOfTwoLayoutsOfOneType) {
  std::string text = "FMT, 6, 15, OLD, Qf, TimeUS,Alt\nFMT, 6, 15, BARO, Qf, TimeUS,Alt\n";
  for (int i = 0; i < 20; ++i)
    text += fmt::format("OLD, {0}, 7\nBARO, {0}, {1}\n", 1'000'000 + i * 100'000, i);
  const auto log = ValueOf(ParseLog("flight.log", BytesOf(text)));
  EXPECT_EQ(log.message_counts, (std::map<std::string, std::uint64_t>{{"BARO", 20}, {"FMT", 2}}));
}

TEST(ParseDataflashText, RefusesLayoutsWithoutMessages) {
  const Error log = ErrorOf(ParseLog("flight.log", BytesOf("FMT, 6, 15, BARO, Qf, TimeUS,Alt\n")));
  EXPECT_EQ(log.code, ErrorCode::kCorrupt);
}

TEST(ParseDataflash, ReadsTheAnglesOfTheFirstMount) {
  DataflashWriter w;
  w.Define(1, "MNT", "QBffffffff", "TimeUS,I,DesRoll,Roll,DesPitch,Pitch,DesYawB,YawB,DesYawE,YawE");
  for (int i = 0; i < 10; ++i) {
    const double us = 5e6 + i * 1e5;
    w.Write(1, {us, 0, 0, 1, -90, -60, 0, 10, 0, 100});
    w.Write(1, {us, 1, 0, 0, 0, 0, 0, 0, 0, 0});
    w.Write(1, {us + 5e4, 0, 0, 1, -90, -60, 0, 10, 0, std::nan("")});  // no heading yet
  }
  const auto log = ValueOf(ParseDataflash("flight.BIN", w.bytes()));
  ASSERT_EQ(log.gimbal.size(), 10u);
  EXPECT_DOUBLE_EQ(log.gimbal[1].t_s, 5.1);
  const auto expected = NedFromYawPitchRoll(DegToRad(100.0), DegToRad(-60.0), DegToRad(1.0));
  EXPECT_LT(expected.angularDistance(log.gimbal[1].ned_from_body), 1e-6);
}

TEST(ParseDataflash, BelievesNoMountThatNeverLookedDown) {
  DataflashWriter w;
  w.Define(1, "MNT", "QBffffffff", "TimeUS,I,DesRoll,Roll,DesPitch,Pitch,DesYawB,YawB,DesYawE,YawE");
  w.Define(2, "BARO", "QBf", "TimeUS,I,Alt");
  for (int i = 0; i < 10; ++i) {
    const double us = 5e6 + i * 1e5;
    w.Write(1, {us, 0, 0, 0, 0, 0, 0, 0, 0, 100});
    w.Write(2, {us, 0, 1.0 * i});
  }
  EXPECT_TRUE(ValueOf(ParseDataflash("flight.BIN", w.bytes())).gimbal.empty());
}

TEST(ParseDataflash, RefusesALogWithoutMessages) {
  DataflashWriter w;
  EXPECT_EQ(ErrorOf(ParseDataflash("empty.bin", w.bytes())).code, ErrorCode::kCorrupt);
}

}  // namespace
}  // namespace skyquilt::flight
