// Whatever happens to a file, a parser answers: with what is readable, or with an error.
#include <gtest/gtest.h>

#include <random>

#include "core/flight/logs/log_builder.h"
#include "core/flight/logs/read_log.h"
#include "core/flight/logs/texts/gcp_list.h"
#include "core/flight/remarks/because.h"
#include "core/flight/remarks/remark_words.h"
#include "tests/core/flight/logs/log_writers.h"
#include "tests/support/temporary_folder.h"

namespace skyquilt::flight {
namespace {

using testing::Append;
using testing::Bytes;

struct Named {
  std::string name;
  Bytes bytes;
};

Bytes FromText(std::string_view text) { return {text.begin(), text.end()}; }

// A small file of every format.
std::vector<Named> SmallFiles() {
  std::vector<Named> files;
  testing::DataflashWriter bin;
  bin.Define(1, "IMU", "QBffffff", "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ");
  bin.Define(3, "GPS", "QBBIHBcLLeffff", "TimeUS,I,Status,GMS,GWk,NSats,HDop,Lat,Lng,Alt,Spd,GCrs,VZ,Yaw");
  for (int i = 0; i < 10; ++i) {
    bin.Write(1, {1e6 + i * 1e4, 0, 0, 0, 0, 0, 0, -9.8});
    bin.Write(3, {1e6 + i * 1e4, 0, 3, 1000.0 * i, 2300, 18, 0.7, 10, 20, 30, 5, 90, 0, 0});
  }
  files.push_back({"a.bin", bin.bytes()});
  testing::UlogWriter ulg;
  ulg.Define("vehicle_air_data:uint64_t timestamp;float baro_alt_meter;");
  ulg.Subscribe(3, "vehicle_air_data");
  for (std::uint64_t i = 0; i < 10; ++i) {
    Bytes payload;
    Append(payload, 1'000'000 + i * 1000);
    Append(payload, 5.0f);
    ulg.Data(3, payload);
  }
  files.push_back({"a.ulg", ulg.bytes()});
  testing::TlogWriter tlog;
  for (std::uint32_t i = 0; i < 10; ++i) {
    Bytes payload;
    Append(payload, i * 250);
    for (int k = 0; k < 6; ++k) Append(payload, 0.5f);
    tlog.Packet(1'650'000'000'000'000 + i * 250'000, 30, 39, payload, i % 2 == 0);
  }
  files.push_back({"a.tlog", tlog.bytes()});
  files.push_back({"a.mrk", FromText("7\t296288.242869\t[2211]\t3,N\t0,E\t75,V\t47.64,Lat\t16.47,Lon\t512.9,"
                                     "Ellh\t0.01, 0.01, 0.02\t50,Q\n")});
  files.push_back({"a.srt", FromText("1\n00:00:01,500 --> 00:00:02,000\n2021-01-01 "
                                     "00:00:00\nGPS(149.0251,-20.2533,16) BAROMETER:1.9\n")});
  files.push_back(
      {"a.ass", FromText("[Events]\nFormat: Layer, Start, End, Text\nDialogue: 0,0:00:01.50,0:00:02.00,"
                         "2021.1.1 00:00:00\\NGPS(W: -91.99, N: 46.84, 198) ReH:40\n")});
  files.push_back(
      {"a.kml",
       FromText("<kml><gx:Track><altitudeMode>absolute</altitudeMode><when>2021-06-01T10:00:00Z</when>"
                "<gx:coord>8.5 47.5 400</gx:coord></gx:Track></kml>")});
  files.push_back(
      {"a.geojson", FromText("{\"type\":\"Feature\",\"properties\":{\"time\":\"2021-06-01T10:00:00Z\"},"
                             "\"geometry\":{\"type\":\"Point\",\"coordinates\":[8.5,47.5,400]}}")});
  files.push_back({"a.pos", FromText("%  GPST  latitude(deg) longitude(deg)  height(m)   Q  ns\n1316 "
                                     "518400.0 35.1 139.6 31.9 2 7 1 2 3\n")});
  files.push_back({"geo.txt", FromText("EPSG:4326\nb.jpg 16.5 47.5 400 10 0 -5 0.02 0.03\n")});
  files.push_back(
      {"gcp_list.txt", FromText("WGS84 UTM 16N\n609925.8 4950688.7 171.6 1331 350 DJI_0002.JPG a\n")});
  files.push_back(
      {"pix4d.csv",
       FromText("image,latitude,longitude,altitude,omega,phi,kappa\na.jpg,47.5,8.5,500,0,0,0\n")});
  files.push_back(
      {"geoinfo.txt",
       FromText(
           "#Rev: sensefly/geoinfo/2\nfileName\tlatitude\tlongitude\ta\tb\nI.JPG\t37.5\t139.0\t1\t2\n")});
  files.push_back(
      {"a.gpx", FromText("<gpx><trkpt lat=\"47.5\" "
                         "lon=\"8.5\"><ele>4</ele><time>2021-06-01T10:00:00Z</time></trkpt></gpx>")});
  files.push_back(
      {"a.nmea", FromText("$GPGGA,000000.00,4730.0006,N,00830.0000,W,1,12,0.7,401.5,M,48.25,M,,*00\n$GPGGA,"
                          "000001.00,4730.0006,N,00830.0000,W,1,12,0.7,401.5,M,48.25,M,,\n")});
  files.push_back(
      {"flight.csv",
       FromText("t,lat,lon,alt_ell,rel_alt,event\n0.5,47.5,8.5,500,10,a.jpg\n1.5,47.5,8.5,500,10,\n")});
  files.push_back({"images.csv", FromText("image,t,lat,lon\na.jpg,1.5,47.5,8.5\n")});
  files.push_back(
      {"airdata.csv",
       FromText("time(millisecond),datetime(utc),latitude,longitude\n100,2021-06-01 10:00:00,47.5,8.5\n")});
  files.push_back(
      {"replay.csv",
       FromText("4000,imu,0,0,-9.8,0,0,0\n4000,baro,5\n8000,gps,488103,85456073,473977508,0,0,0\n")});
  return files;
}

// The promises of flight_log.h.
void ExpectOrderly(const FlightLog& log) {
  const auto rising = [](const auto& samples) {
    for (std::size_t i = 0; i < samples.size(); ++i) {
      if (!std::isfinite(samples[i].t_s) || (i > 0 && samples[i].t_s < samples[i - 1].t_s)) return false;
    }
    return true;
  };
  EXPECT_TRUE(rising(log.imu) && rising(log.attitude) && rising(log.gnss) && rising(log.baro) &&
              rising(log.range) && rising(log.events) && rising(log.gimbal))
      << log.format;
  for (const GnssSample& sample : log.gnss) {
    EXPECT_TRUE(geo::LatLon::Make(sample.position.lat_deg, sample.position.lon_deg).ok());
  }
}

void Try(const std::string& name, LogBytes bytes) {
  // A copy of exactly this size, so that a memory checker sees every step beyond it.
  const Bytes exact(bytes.begin(), bytes.end());
  const auto log = ParseLog(name, exact);
  if (log.ok())
    ExpectOrderly(*log);
  else
    EXPECT_TRUE(HasReason(log.error())) << log.error().message;
  const auto list = ParseGcpList(name, exact);
  if (list.ok()) {
    for (const GcpSighting& sighting : list->sightings) EXPECT_LT(sighting.point, list->points.size());
  }
}

TEST(DamagedLogs, EverySmallFileIsFineWhole) {
  for (const Named& file : SmallFiles()) {
    if (file.name == "gcp_list.txt") continue;
    const auto log = ParseLog(file.name, file.bytes);
    EXPECT_TRUE(log.ok()) << file.name << ": " << (log.ok() ? "" : log.error().message);
  }
}

TEST(DamagedLogs, AnyTruncationIsSurvived) {
  for (const Named& file : SmallFiles()) {
    for (std::size_t size = 0; size < file.bytes.size(); ++size)
      Try(file.name, LogBytes(file.bytes).first(size));
  }
}

TEST(DamagedLogs, AnyOneByteIsSurvived) {
  std::mt19937 random(7);
  for (const Named& file : SmallFiles()) {
    for (int round = 0; round < 400; ++round) {
      Bytes bytes = file.bytes;
      for (unsigned k = 0; k < 1 + random() % 8; ++k)
        bytes[random() % bytes.size()] = static_cast<std::uint8_t>(random());
      Try(file.name, bytes);
    }
  }
}

TEST(DamagedLogs, GarbageIsNoLog) {
  std::mt19937 random(11);
  for (int round = 0; round < 200; ++round) {
    Bytes bytes(random() % 5000);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
    EXPECT_FALSE(ParseLog("garbage", bytes).ok());
  }
}

TEST(DamagedLogs, ACutLogKeepsWhatCameBefore) {
  for (const Named& file : SmallFiles()) {
    if (file.name != "a.bin" && file.name != "a.ulg" && file.name != "a.tlog") continue;
    const auto log = ParseLog(file.name, LogBytes(file.bytes).first(file.bytes.size() - 3));
    ASSERT_TRUE(log.ok()) << file.name;
    EXPECT_EQ(log->imu.size() + log->baro.size() + log->attitude.size(), file.name == "a.bin" ? 10u : 9u)
        << file.name;
    bool said = false;
    for (const auto& warning : InWords(log->warnings))
      said = said || warning.find("cut off") != std::string::npos;
    EXPECT_TRUE(said) << file.name;
  }
}

TEST(CappedSeries, ThinsEvenlyAndAveragesTheImu) {
  LogBuilder builder("test", "a", 1000, 100);
  for (int i = 0; i < 100'000; ++i) {
    const double t_s = i * 0.001;
    builder.Add(ImuSample{t_s, Eigen::Vector3d(i % 2 == 0 ? 1.0 : -1.0, 0, 0), Eigen::Vector3d(0, 0, -9.8)});
    builder.Add(BaroSample{t_s, t_s});
  }
  const FlightLog log = std::move(builder).Finish();
  EXPECT_LE(log.imu.size(), 1000u);
  EXPECT_GE(log.imu.size(), 500u);
  EXPECT_LE(log.baro.size(), 100u);
  for (const ImuSample& sample : log.imu)
    EXPECT_NEAR(sample.angular_rate_radps.x(), 0.0, 1e-9) << "the mean, not a choice";
  EXPECT_LT(log.imu.front().t_s, 0.2);
  EXPECT_GT(log.imu.back().t_s, 99.7);
  EXPECT_EQ(log.warnings.size(), 2u);
}

TEST(YawPitchRoll, RoundTripsThroughTheQuaternion) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> angle(-3.1, 3.1), pitch(-1.55, 1.55);
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Vector3d expected(angle(random), pitch(random), angle(random));
    const Eigen::Vector3d got =
        YawPitchRollFromNed(NedFromYawPitchRoll(expected[0], expected[1], expected[2]));
    EXPECT_LT((got - expected).norm(), 1e-9);
  }
}

TEST(ReadLog, ReadsFilesAndSaysWhatIsMissing) {
  const test::TemporaryFolder folder;
  for (const Named& file : SmallFiles()) {
    if (file.name == "gcp_list.txt") continue;
    EXPECT_TRUE(ReadLog({file.name, folder.Write(file.name, file.bytes)}).ok()) << file.name;
  }
  EXPECT_EQ(ReadLog({"none", folder / "none"}).error().code, ErrorCode::kIo);
  EXPECT_EQ(ReadLog({"folder", folder.path()}).error().code, ErrorCode::kIo);
}

}  // namespace
}  // namespace skyquilt::flight
