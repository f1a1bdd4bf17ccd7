#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>

#include "core/flight/bytes/gps_time.h"
#include "core/flight/logs/csv/csv_columns.h"
#include "core/flight/logs/explain_unknown.h"
#include "core/flight/logs/formats.h"
#include "core/flight/logs/log_builder.h"
#include "core/flight/logs/read_log.h"
#include "core/flight/remarks/because.h"
#include "core/flight/remarks/remark_words.h"
#include "tests/support/value_of.h"

namespace skyquilt::flight {
namespace {

using geo::DegToRad;
using test::ErrorOf;
using test::ValueOf;

TEST(ParseFlightCsv, ReadsSparseRowsOfAnySubset) {
  const std::string text =
      "t,wx,wy,wz,ax,ay,az,lat,lon,alt_ell,vn,ve,vd,sh,sv,fix,roll,pitch,yaw,baro_alt,range,event\n"
      "0.000,0.01,0.02,0.03,0.1,0.2,-9.8,,,,,,,,,,,,,,,\n"
      "0.005,0.01,0.02,0.03,0.1,0.2,-9.8,47.5,8.5,500.5,1,2,-3,0.01,0.02,6,,,,,,\n"
      "0.010,,,,,,,,,,,,,,,,10,-5,90,100.5,20.25,DJI_0001.JPG\n"
      "bad,1,2,3,4,5,6,,,,,,,,,,,,,,,\n"
      "0.020,,,,,,,,,,,,,,,,,,,103.5,,17\n";
  ASSERT_TRUE(LooksLikeFlightCsv(BytesOf(text)));
  EXPECT_FALSE(LooksLikeImagesCsv(BytesOf(text)));
  const auto log = ValueOf(ParseFlightCsv("flight.csv", BytesOf(text)));
  ASSERT_EQ(log.imu.size(), 2u);
  EXPECT_DOUBLE_EQ(log.imu[1].specific_force_mps2.z(), -9.8);
  ASSERT_EQ(log.gnss.size(), 1u);
  EXPECT_DOUBLE_EQ(log.gnss[0].velocity_in_ned_mps->z(), -3.0);
  EXPECT_TRUE(log.gnss[0].is_rtk_fixed);
  EXPECT_DOUBLE_EQ(*log.gnss[0].height_ellipsoid_m, 500.5);
  ASSERT_EQ(log.attitude.size(), 1u);
  EXPECT_LT(log.attitude[0].ned_from_body.angularDistance(
                NedFromYawPitchRoll(DegToRad(90.0), DegToRad(-5.0), DegToRad(10.0))),
            1e-9);
  ASSERT_EQ(log.baro.size(), 2u);
  EXPECT_DOUBLE_EQ(log.baro[1].height_above_takeoff_m - log.baro[0].height_above_takeoff_m, 3.0);
  EXPECT_DOUBLE_EQ(log.range.at(0).distance_m, 20.25);
  ASSERT_EQ(log.events.size(), 2u);
  EXPECT_EQ(*log.events[0].image_name, "DJI_0001.JPG");
  EXPECT_EQ(*log.events[1].sequence, 17);
  ASSERT_EQ(log.warnings.size(), 2u);
  EXPECT_EQ(InWords(log.warnings[0]), "line 5: column \"t\" holds \"bad\", which cannot be read as time");
}

TEST(ParseFlightCsv, TakesUtcInsteadOfSeconds) {
  const std::string text =
      "utc,qw,qx,qy,qz,press\n2024-01-01T10:00:00.250Z,1,0,0,0,101325\n2024-01-01T10:00:00.500Z,0.5,0.5,0.5,"
      "0.5,101313\n";
  const auto log = ValueOf(ParseFlightCsv("flight.csv", BytesOf(text)));
  EXPECT_EQ(*log.utc_at_zero, *UtcFromCivil(2024, 1, 1, 10, 0, 0.25));
  EXPECT_DOUBLE_EQ(log.attitude.at(1).t_s, 0.25);
  EXPECT_NEAR(log.baro.at(1).height_above_takeoff_m - log.baro.at(0).height_above_takeoff_m, 1.0, 0.05)
      << "12 Pa a metre";
}

TEST(ParseImagesCsv, ReadsPosesOfPhotos) {
  const std::string text =
      "image,utc,lat,lon,alt_ell,yaw,pitch,roll,sh,sv,s_rp,s_yaw\n"
      "a.jpg,2024-01-01T10:00:00Z,47.5,8.5,500,10,-90,0,0.02,0.03,0.5,2\n"
      "b.jpg,2024-01-01T10:00:02.5Z,47.6,8.5,500,,,,,,,\n";
  EXPECT_EQ(ValueOf(ParseLog("whatever.dat", BytesOf(text))).format, "images_csv");
  const auto log = ValueOf(ParseImagesCsv("images.csv", BytesOf(text)));
  ASSERT_EQ(log.events.size(), 2u);
  EXPECT_NEAR((*log.events[0].yaw_pitch_roll_rad)[1], DegToRad(-90.0), 1e-12);
  EXPECT_EQ(log.events[0].attitude_kind, AttitudeKind::kGimbal);
  EXPECT_NEAR(*log.events[0].sigma_yaw_rad, DegToRad(2.0), 1e-12);
  EXPECT_DOUBLE_EQ(log.events[1].t_s, 2.5);
}

TEST(ParseTolerantCsv, ReadsAirDataInFeetAndMilesPerHour) {
  std::string text =
      "time(millisecond),datetime(utc),latitude,longitude,height_above_takeoff(feet),altitude_above_seaLevel("
      "feet),"
      "height_sonar(feet),speed(mph), xSpeed(mph), ySpeed(mph), zSpeed(mph), compass_heading(degrees), "
      "pitch(degrees), "
      "roll(degrees),isPhoto,gimbal_heading(degrees),gimbal_pitch(degrees),gimbal_roll(degrees),message\n";
  for (int i = 0; i < 100; ++i) {
    const int ms = 700 + i * 100;  // the clock of the date ticked 0.3 s after the log began
    text += std::to_string(i * 100) + ",2021-06-01 10:00:0" + std::to_string(ms / 1000 % 10) + ",47." +
            std::to_string(500000 + i) + ",8.5,100,1500," + (i == 5 ? "10" : "0") + ",5,10,0,-1,90,1,2," +
            (i % 20 == 7 || i % 20 == 8 ? "1" : "0") + ",91,-90,0,\"Obstacle, avoided\"\n";
  }
  ASSERT_TRUE(LooksLikeTolerantCsv(BytesOf(text)));
  const auto log = ValueOf(ParseTolerantCsv("airdata.csv", BytesOf(text)));
  ASSERT_EQ(log.gnss.size(), 100u);
  EXPECT_DOUBLE_EQ(log.gnss[3].t_s, 0.3);
  EXPECT_NEAR(*log.gnss[0].height_amsl_m, 457.2, 1e-9);
  EXPECT_NEAR(log.gnss[0].velocity_in_ned_mps->x(), 4.4704, 1e-9);
  EXPECT_NEAR(log.baro.at(0).height_above_takeoff_m, 30.48, 1e-9);
  ASSERT_EQ(log.range.size(), 1u) << "0 feet is no reading";
  EXPECT_NEAR(log.range[0].distance_m, 3.048, 1e-9);
  EXPECT_EQ(log.gimbal.size(), 100u);
  ASSERT_EQ(log.events.size(), 5u) << "two rows of one photo are one event";
  EXPECT_DOUBLE_EQ(log.events[0].t_s, 0.7);
  // Whole seconds were written; the finest reading of them is 0.3 s after the truth at most.
  const double zero_s =
      std::chrono::duration<double>(*log.utc_at_zero - *UtcFromCivil(2021, 6, 1, 10, 0, 0.0)).count();
  EXPECT_NEAR(zero_s, 0.7, 0.15);
  bool echoed = false;
  for (const auto& line : log.mapping) echoed = echoed || line == "xSpeed(mph) -> velocity north, mph";
  EXPECT_TRUE(echoed);
}

// One minute of a hover that turns, with accelerations in `accel_unit` of m/s2 and rates in `rate_unit` of
// rad/s.
std::string PhoneLog(const std::string& header, double time_unit, double accel_unit, double rate_unit,
                     bool z_up) {
  std::string text = header + "\n";
  for (int i = 0; i < 3000; ++i) {
    const double t = i * 0.02;
    const double yaw_rate = 0.5 * std::sin(0.5 * t);
    const double yaw = 1.0 - std::cos(0.5 * t);
    const double z = (z_up ? 9.81 : -9.81) + 0.3 * std::sin(9.0 * t);
    text += std::to_string(t / time_unit) + "," + std::to_string(0.1 / accel_unit) + "," +
            std::to_string(-0.2 / accel_unit) + "," + std::to_string(z / accel_unit) + ",0,0," +
            std::to_string((z_up ? -yaw_rate : yaw_rate) / rate_unit) + ",0,0," +
            std::to_string(yaw * 180.0 / M_PI) + "\n";
  }
  return text;
}

TEST(ParseTolerantCsv, FindsUnitsAndAxesByPhysics) {
  struct Case {
    double time_unit, accel_unit, rate_unit;
    bool z_up;
  };
  for (const Case& c : {Case{1.0, 1.0, 1.0, false}, Case{1e-3, 9.80665, M_PI / 180.0, true},
                        Case{1e-6, 9.80665e-3, 1.0, false}, Case{1e-9, 1.0, M_PI / 180.0, true}}) {
    const auto log = ValueOf(ParseTolerantCsv(
        "phone.csv", BytesOf(PhoneLog("timestamp,acc_x,acc_y,acc_z,gyro_x,gyro_y,gyro_z,roll,pitch,yaw",
                                      c.time_unit, c.accel_unit, c.rate_unit, c.z_up))));
    ASSERT_EQ(log.imu.size(), 3000u);
    EXPECT_NEAR(log.imu[100].t_s, 2.0, 1e-6) << c.time_unit;
    EXPECT_NEAR(log.imu[100].specific_force_mps2.z(), -9.81, 0.4) << c.accel_unit;
    EXPECT_NEAR(log.imu[100].specific_force_mps2.x(), 0.1, 0.01);
    EXPECT_NEAR(log.imu[100].specific_force_mps2.y(), c.z_up ? 0.2 : -0.2, 0.01);
    EXPECT_NEAR(log.imu[100].angular_rate_radps.z(), 0.5 * std::sin(1.0), 1e-3) << c.rate_unit;
  }
}

TEST(ParseTolerantCsv, NamesTheColumnThatContradictsPhysics) {
  const Error wrong_accel = ErrorOf(ParseTolerantCsv(
      "a.csv", BytesOf(PhoneLog("time(s),ax(g),ay(g),az(g),gx,gy,gz,roll,pitch,yaw", 1.0, 1.0, 1.0, false))));
  EXPECT_EQ(wrong_accel.code, ErrorCode::kUnprocessable);
  EXPECT_NE(wrong_accel.message.find("ax(g)"), std::string::npos);
  EXPECT_TRUE(HasReason(wrong_accel));
  const Error wrong_rate = ErrorOf(ParseTolerantCsv(
      "b.csv",
      BytesOf(PhoneLog("time(s),ax,ay,az,gyro_x [rad/s],gyro_y [rad/s],gyro_z [rad/s],roll,pitch,yaw", 1.0,
                       1.0, M_PI / 180.0, false))));
  EXPECT_NE(wrong_rate.message.find("gyro_x [rad/s]"), std::string::npos);
}

TEST(ParseTolerantCsv, SpreadsRowsOfACoarseClock) {
  std::string text = "utc;lat;lon\n";
  for (int i = 0; i < 50; ++i) {
    text += "2021-06-01 10:00:0" + std::to_string(i / 10) + ";47." + std::to_string(500000 + i) + ";8.5\n";
  }
  const auto log = ValueOf(ParseTolerantCsv("coarse.csv", BytesOf(text)));
  ASSERT_EQ(log.gnss.size(), 50u) << "none is thrown away as a duplicate";
  EXPECT_NEAR(log.gnss[25].t_s, 2.5, 0.01);
}

TEST(RecogniseLog, GoesByContent) {
  EXPECT_FALSE(RecogniseLog(BytesOf("just a text file\nwith lines\n"), "flight.BIN")->has_value());
  EXPECT_FALSE(RecogniseLog(BytesOf("Dear all,\nplease find, time, attached\n"), "a.csv")->has_value());
  const std::string jpeg = "\xFF\xD8\xFF\xE1 not a log";
  EXPECT_FALSE(RecogniseLog(BytesOf(jpeg), "a.tlog")->has_value());
  const std::string binary = std::string("\x00\x01\x02\x03\x9A\xFF", 6);
  const Error encrypted = ErrorOf(RecogniseLog(BytesOf(binary), "DJIFlightRecord_2021-06-01_[10-00-00].txt"));
  EXPECT_EQ(encrypted.code, ErrorCode::kUnsupportedFormat);
  EXPECT_NE(encrypted.message.find("AirData"), std::string::npos);
}

// Tables as people write them: units behind the names in any case, tables of exposures, tables that no reader
// knows.

using M = CsvMeaning;
using ::testing::HasSubstr;

TEST(MapTolerantColumns, ReadsUnitsBehindNamesInAnyCase) {
  struct Case {
    M meaning;
    double scale;
    std::vector<std::string_view> headers;
  };
  const double deg = 3.14159265358979323846 / 180.0;
  for (const Case& c :
       {Case{M::kLat, 1.0, {"lat_deg", "LAT_DEG", "latDeg", "Latitude [deg]", "LATDEG"}},
        Case{M::kLon, 1.0, {"lonDeg", "longitude_degrees"}}, Case{M::kLat, 1e-7, {"latE7"}},
        Case{M::kLon, 1.0 / deg, {"lon_rad"}}, Case{M::kHeightAmsl, 1.0, {"alt_m"}},
        Case{M::kHeightAmsl, 0.3048, {"AltFt"}}, Case{M::kSigmaHorizontal, 1.0, {"hacc_m"}},
        Case{M::kSigmaHorizontal, 1e-3, {"hAccMm"}}, Case{M::kTime, 1.0, {"time_s", "Time_S"}},
        Case{M::kTime, 1e-6, {"TimeUS"}}, Case{M::kTime, 1e-3, {"timestamp_ms", "timems"}},
        Case{M::kGyroX, deg, {"gyro_x_deg_s"}}, Case{M::kVelocityNorth, 1.0, {"velN_m_s"}},
        Case{M::kYaw, deg, {"yaw_deg"}}, Case{M::kIgnored, 1.0, {"ts", "lat_m", "latest", "speed_mps"}}}) {
    for (const std::string_view header : c.headers) {
      const CsvColumn column = MapTolerantColumns({header}).at(0);
      EXPECT_EQ(column.meaning, c.meaning) << header;
      if (c.meaning != M::kIgnored) {
        EXPECT_DOUBLE_EQ(column.scale, c.scale) << header;
      }
    }
  }
}

TEST(ParseTolerantCsv, ReadsAGnssLogWithUnitsInItsNames) {
  const std::string text =
      "time_s,lat_deg,lon_deg,alt_m,hacc_m\n100.0,46.8,7.1,500.5,1.5\n100.2,46.800001,7.1,500.6,1.4\n";
  const auto log = ValueOf(ParseLog("gnss.csv", BytesOf(text)));
  EXPECT_EQ(log.format, "tolerant_csv");
  ASSERT_EQ(log.gnss.size(), 2u);
  EXPECT_NEAR(log.gnss[1].t_s, 0.2, 1e-9);
  EXPECT_DOUBLE_EQ(*log.counter_at_zero_s, 100.0);
  EXPECT_DOUBLE_EQ(log.gnss[1].position.lat_deg, 46.800001);
  EXPECT_DOUBLE_EQ(*log.gnss[0].height_amsl_m, 500.5);
  EXPECT_DOUBLE_EQ(*log.gnss[0].sigma_horizontal_m, 1.5);
}

TEST(ParseTolerantCsv, TakesNoHeightThatMayCountFromTheSeaForOneAboveTheTakeoff) {
  const auto track = [](const std::string& heights, const std::string& cells) {
    std::string text = "time_s,lat,lon," + heights + "\n";
    for (int i = 0; i < 5; ++i)
      text += std::to_string(i) + ",46.80000" + std::to_string(i) + ",7.1," + cells + "\n";
    return ValueOf(ParseLog("track.csv", BytesOf(text)));
  };
  for (const char* name : {"altura", "Hauteur (m)"}) {
    const auto log = track(name, "650");
    EXPECT_EQ(log.gnss.size(), 5u) << name;
    EXPECT_TRUE(log.baro.empty()) << name;
    ASSERT_EQ(log.warnings.size(), 1u) << name;
    EXPECT_EQ(log.warnings[0].code, RemarkCode::kColumnWordsUnknown) << name;
  }
  const auto both = track("altura,altitud", "60,650");
  EXPECT_EQ(both.gnss.at(0).height_amsl_m, 650.0);
  EXPECT_EQ(both.baro.at(0).height_above_takeoff_m, 60.0);
}

TEST(ParseTolerantCsv, TakesHeightsThatNeverComeDownForThoseOfAReceiver) {
  const auto track = [](const std::string& name, const std::string& first) {
    return ValueOf(ParseLog("track.csv", BytesOf("time_s,lat,lon," + name + "\n1,46.8,7.1," + first +
                                                 "\n2,46.8001,7.1,547.5\n3,46.8002,7.1,548.5\n")));
  };
  const FlightLog receiver = track("height_m", "487.5");
  EXPECT_TRUE(receiver.baro.empty());
  EXPECT_EQ(receiver.gnss.at(1).height_ellipsoid_m, 547.5);
  for (const FlightLog& flown : {track("height_m", "0.5"), track("height_above_takeoff_m", "487.5")}) {
    ASSERT_EQ(flown.baro.size(), 3u);
    EXPECT_EQ(flown.baro[1].height_above_takeoff_m, 547.5);
  }
  // A recorder of inertial samples that knows no height before it is armed.
  std::string late = "time_s,lat,lon,height_m\n";
  for (int row = 0; row < 5010; ++row)
    late += std::to_string(0.01 * row) + ",46.8,7.1," + (row < 5005 ? "" : "1") + "\n";
  EXPECT_EQ(ValueOf(ParseLog("track.csv", BytesOf(late))).baro.size(), 5u);
}

TEST(ParseTolerantCsv, CountsAltitudesThatBeginAtZeroFromTheTakeoff) {
  const auto track = [](const std::string& altitude, std::initializer_list<const char*> heights) {
    std::string text = "latitude,longitude," + altitude + ",time(millisecond),datetime(utc)\n0,0,0,0,\n";
    int row = 0;
    for (const char* const height : heights) {
      const std::string second = std::to_string(++row);
      text +=
          "46.80000" + second + ",7.1," + height + "," + second + "000,2021-06-01 10:00:0" + second + "\n";
    }
    return ValueOf(ParseLog("litchi.csv", BytesOf(text)));
  };
  const auto is_told = [](const FlightLog& log) {
    return std::any_of(log.warnings.begin(), log.warnings.end(),
                       [](const Remark& said) { return said.code == RemarkCode::kAltitudesFromTakeoff; });
  };
  const FlightLog litchi = track("altitude(m)", {"0.0", "0.1", "4.0", "12.5", "20"});
  ASSERT_EQ(litchi.gnss.size(), 5u);
  EXPECT_FALSE(litchi.gnss[4].height_amsl_m);
  ASSERT_EQ(litchi.baro.size(), 6u) << "also before the first fix";
  EXPECT_DOUBLE_EQ(litchi.baro[5].height_above_takeoff_m, 20.0);
  EXPECT_TRUE(is_told(litchi));
  for (const FlightLog& log : {track("altitude(m)", {"0", "0", "450", "451", "455"}),
                               track("altitude(m)", {"2", "4", "8", "12", "20"}),
                               track("altitude_amsl(m)", {"0", "4", "8", "12", "20"}),
                               track("altitude(m)", {"0", "0.5", "1", "1", "0"})}) {
    EXPECT_TRUE(log.baro.empty());
    EXPECT_TRUE(log.gnss.at(4).height_amsl_m);
    EXPECT_FALSE(is_told(log));
  }
}

TEST(ParseTolerantCsv, TakesHeightsThatAreAllZeroForUnknown) {
  const auto track = [](const std::string& last) {
    return ValueOf(ParseLog(
        "track.csv", BytesOf("time_s,lat,lon,height_above_takeoff_m,altitude_amsl_m\n1,46.8,7.1,50,0.0\n"
                             "2,46.8001,7.1,60,0\n3,46.8002,7.1,60," +
                             last + "\n")));
  };
  const FlightLog none = track("0");
  ASSERT_EQ(none.gnss.size(), 3u);
  EXPECT_FALSE(none.gnss[0].height_amsl_m);
  EXPECT_EQ(none.baro.size(), 3u);
  ASSERT_EQ(none.warnings.size(), 1u);
  EXPECT_EQ(none.warnings[0].code, RemarkCode::kHeightsNotSurveyed);
  EXPECT_EQ(track("2.5").gnss.at(0).height_amsl_m, 0.0) << "by the sea";
}

TEST(ParseTolerantCsv, ReadsATableOfExposuresByName) {
  for (const char* header : {"time_s,photo", "Time_S,Photo", "time_s,image", "time_s,filename"}) {
    const std::string text = std::string(header) + "\n103.5,IMG_1.jpg\n106.5,IMG_2.jpg\n109.75,IMG_3.jpg\n";
    const auto log = ValueOf(ParseLog("triggers.csv", BytesOf(text)));
    ASSERT_EQ(log.events.size(), 3u) << header;
    EXPECT_EQ(log.events[1].image_name, "IMG_2.jpg");
    EXPECT_TRUE(log.events[1].has_time);
    EXPECT_NEAR(log.events[2].t_s + *log.counter_at_zero_s, 109.75, 1e-9) << header;
  }
}

TEST(ParseTolerantCsv, TellsSecondsOfExposuresFromMilliseconds) {
  const auto seconds = ValueOf(ParseLog("a.csv", BytesOf("time,photo\n10,a.jpg\n13,b.jpg\n16,c.jpg\n")));
  EXPECT_NEAR(seconds.events.at(2).t_s, 6.0, 1e-9);
  const auto milliseconds =
      ValueOf(ParseLog("a.csv", BytesOf("time,photo\n10000,a.jpg\n13000,b.jpg\n16000,c.jpg\n")));
  EXPECT_NEAR(milliseconds.events.at(2).t_s, 6.0, 1e-9);
}

TEST(ParseTolerantCsv, TellsNumbersOfPhotosFromFlags) {
  const auto numbers = ValueOf(ParseLog("a.csv", BytesOf("time_s,photo\n10,1\n13,2\n16,3\n")));
  ASSERT_EQ(numbers.events.size(), 3u);
  EXPECT_EQ(numbers.events[2].sequence, 3);
  const auto flags = ValueOf(ParseLog(
      "a.csv", BytesOf("time_s,lat,lon,photo\n1,46,7,0\n2,46,7,1\n3,46,7,1\n4,46,7,0\n5,46,7,true\n")));
  ASSERT_EQ(flags.events.size(), 2u);
  EXPECT_FALSE(flags.events[0].image_name);
}

TEST(ParseTolerantCsv, ReadsPlacesOfNamedPhotosWithoutTimes) {
  const std::string text =
      "photo;latDeg;lonDeg;alt_m;hacc_m\nIMG_1.jpg;46.8;7.1;560;0.02\nIMG_2.jpg;46.81;7.11;561;0.02\n;46.8;7.1;1;1\n";
  const auto log = ValueOf(ParseLog("places.csv", BytesOf(text)));
  ASSERT_EQ(log.events.size(), 2u);
  EXPECT_FALSE(log.events[1].has_time);
  EXPECT_EQ(log.events[1].image_name, "IMG_2.jpg");
  EXPECT_DOUBLE_EQ(log.events[1].position->lat_deg, 46.81);
  EXPECT_EQ(log.events[1].height_ellipsoid_m, 561.0) << "the zero of lists that name none";
  EXPECT_EQ(log.warnings.size(), 1u);
}

TEST(ExplainUnknownTable, SaysWhatATableLacks) {
  const auto no_time =
      ValueOf(ExplainUnknownTable(BytesOf("stamp,lat_deg,lon_deg\n1,46.8,7.1\n2,46.8,7.1\n"), "track.csv"));
  EXPECT_THAT(InWords(no_time), HasSubstr("track.csv"));
  EXPECT_THAT(InWords(no_time), HasSubstr("no column of it is recognised as a time"));
  EXPECT_THAT(InWords(no_time), HasSubstr("recognised are lat_deg, lon_deg"));
  EXPECT_THAT(InWords(no_time), HasSubstr("not recognised are stamp"));
  const auto no_use = ValueOf(ExplainUnknownTable(BytesOf("time_s,battery\n1,46\n2,46\n"), "power.csv"));
  EXPECT_THAT(InWords(no_use), HasSubstr("beside the time"));
  const auto in_parts = ValueOf(ExplainUnknownTable(
      BytesOf("image,lat_deg,lat_min,lon_deg,lon_min\na.jpg,46,50.5,8,7.4\nb.jpg,46,50.6,8,7.5\n"),
      "parts.csv"));
  EXPECT_THAT(InWords(in_parts), HasSubstr("each in one column of decimal degrees"));
  const auto marks = ValueOf(ExplainUnknownTable(
      BytesOf("gcp,lat,lon,alt,px,py,image\np1,46.8,7.1,500,10,20,a.jpg\np2,46.8,7.1,500,10,20,b.jpg\n"),
      "marks.csv"));
  EXPECT_THAT(InWords(marks), HasSubstr("list of surveyed points, but is not used: column 1 of line 2"));
  EXPECT_FALSE(ExplainUnknownTable(BytesOf("Dear all,\nplease find, time, attached\n"), "a.csv"));
  EXPECT_FALSE(ExplainUnknownTable(BytesOf("a,b\nonly,words\nhere,too\n"), "a.csv"));
  EXPECT_FALSE(ExplainUnknownTable(BytesOf(""), "a.csv"));
  std::string wide = "c0";
  std::string row = "0";
  for (int i = 1; i < 1000; ++i) {
    wide += "," + std::string(500, 'x');
    row += ",1";
  }
  const auto bounded = ValueOf(ExplainUnknownTable(BytesOf(wide + "\n" + row + "\n" + row + "\n"), "a.csv"));
  EXPECT_LT(InWords(bounded).size(), 1000u);
}

}  // namespace
}  // namespace skyquilt::flight
