// Real logs of other people. The counts come from count_messages.py, an independent reader (binary formats),
// and from `grep -c` over the text files.
#include <gtest/gtest.h>

#include <filesystem>

#include "core/flight/logs/read_log.h"
#include "core/flight/logs/texts/gcp_list.h"
#include "tests/core/flight/logs/log_writers.h"
#include "tests/support/value_of.h"

namespace skyquilt::flight {
namespace {

using test::ErrorOf;
using test::ValueOf;

Result<FlightLog> Read(const std::string& sample) {
  const std::filesystem::path path = std::filesystem::path(testing::SampleLogsFolder()) / sample;
  return ReadLog({path.filename().string(), path});
}

#define SKIP_WITHOUT_SAMPLES()                         \
  if (testing::SampleLogsFolder().empty())             \
  GTEST_SKIP() << "the sample logs are not here (set " \
                  "SKYQUILT_DATA)"

void ExpectCounts(const FlightLog& log, std::uint64_t total,
                  const std::map<std::string, std::uint64_t>& some) {
  std::uint64_t sum = 0;
  for (const auto& [name, count] : log.message_counts) sum += count;
  EXPECT_EQ(sum, total) << log.file_name;
  for (const auto& [name, count] : some) {
    const auto found = log.message_counts.find(name);
    ASSERT_NE(found, log.message_counts.end()) << name;
    EXPECT_EQ(found->second, count) << name;
  }
}

TEST(SampleLogs, DataflashCountsAgreeWithAnIndependentReader) {
  SKIP_WITHOUT_SAMPLES();
  const auto first = ValueOf(Read("dataflash/px4tools_16-07-13_17-52-16.bin"));
  ExpectCounts(first, 62123,
               {{"IMU", 12772}, {"GPS", 1305}, {"ATT", 2555}, {"BARO", 2555}, {"PARM", 417}, {"FMT", 44}});
  EXPECT_EQ(first.imu.size(), 12772u);
  EXPECT_EQ(first.gnss.size(), 1305u);
  const auto second = ValueOf(Read("dataflash/px4tools_16-07-13_18-04-04.bin"));
  ExpectCounts(second, 74969, {{"IMU", 15437}, {"GPS", 1579}, {"ATT", 3088}, {"EKF1", 3088}});
  // The flights began at noon of 13 July 2016 in Brazil; the first stands before the second.
  EXPECT_LT(*first.utc_at_zero, *second.utc_at_zero);
  const auto cut = ValueOf(Read("dataflash/pymavlink_test.BIN"));
  ExpectCounts(cut, 1731, {{"IMU", 45}, {"GPS", 5}, {"NKF1", 24}, {"PARM", 809}, {"FMT", 132}});
  EXPECT_DOUBLE_EQ(*cut.gnss.at(0).sigma_horizontal_m, 1.61) << "from GPA";
}

TEST(SampleLogs, UlogCountsAgreeWithAnIndependentReader) {
  SKIP_WITHOUT_SAMPLES();
  const auto bench = ValueOf(Read("ulog/sample.ulg"));
  ExpectCounts(bench, 64542,
               {{"sensor_combined", 17070}, {"vehicle_attitude", 6461}, {"sensor_preflight", 17072}});
  EXPECT_NEAR(bench.imu.at(100).specific_force_mps2.norm(), 9.8, 0.3);
  const auto small = ValueOf(Read("ulog/sample_log_small.ulg"));
  ExpectCounts(small, 14604,
               {{"sensor_combined", 1298},
                {"vehicle_gps_position", 32},
                {"vehicle_imu[2]", 12},
                {"vehicle_air_data", 120}});
  EXPECT_NEAR(small.gnss.at(0).position.lat_deg, 63.417, 0.001);
  EXPECT_NEAR(*small.gnss.at(0).height_ellipsoid_m - *small.gnss.at(0).height_amsl_m, 39.95, 0.5);
  EXPECT_NE(ErrorOf(Read("ulog/sample_appended.ulg")).message.find("empty"), std::string::npos);
}

TEST(SampleLogs, TelemetryCountsAgreeWithAnIndependentReader) {
  SKIP_WITHOUT_SAMPLES();
  const auto log = ValueOf(Read("tlog/vtol.tlog"));
  ExpectCounts(log, 23894,
               {{"ATTITUDE", 888},
                {"GPS_RAW_INT", 799},
                {"GLOBAL_POSITION_INT", 807},
                {"RAW_IMU", 795},
                {"MSG_87", 795}});
  EXPECT_GT(log.attitude.size(), 850u);
  EXPECT_TRUE(log.imu.empty()) << "4 Hz cannot be integrated";
}

TEST(SampleLogs, ExposureLogsHaveARowPerPhoto) {
  SKIP_WITHOUT_SAMPLES();
  const auto dji = ValueOf(Read("mrk/go-rtk_100_0004_Timestamp.MRK"));
  EXPECT_EQ(dji.format, "dji_mrk");
  EXPECT_EQ(dji.events.size(), 163u);
  EXPECT_FALSE(dji.events.at(0).is_rtk_fixed);
  const auto autel = ValueOf(Read("mrk/helenenschacht_101FTASK_Timestamp.mrk"));
  EXPECT_EQ(autel.events.size(), 176u);
  EXPECT_EQ(*autel.events.at(0).sequence, 2);
  EXPECT_TRUE(autel.events.at(0).is_rtk_fixed);
  EXPECT_EQ(ValueOf(Read("mrk/go-rtk_test.pos")).gnss.size(), 115u);
}

TEST(SampleLogs, SubtitlesOfEveryDialectGivePositions) {
  SKIP_WITHOUT_SAMPLES();
  const std::map<std::string, std::pair<std::size_t, double>> expected = {
      {"air2s.srt", {17, 41.4247}},        {"broken_incomplete.SRT", {19, -34.7383}},
      {"matrice_300.srt", {381, 36.6146}}, {"mavic_air2.srt", {25, 41.4207}},
      {"old_format.SRT", {468, -20.2533}}, {"p4_rtk.SRT", {55, -34.2379}}};
  for (const auto& [name, facts] : expected) {
    const auto log = ValueOf(Read("srt/" + name));
    EXPECT_EQ(log.format, "dji_srt");
    EXPECT_EQ(log.gnss.size(), facts.first) << name;
    EXPECT_NEAR(log.gnss.at(0).position.lat_deg, facts.second, 1e-4) << name;
  }
  EXPECT_FALSE(Read("srt/Mini_SE.SRT").ok());
}

TEST(SampleLogs, TablesAreRecognisedAndMapped) {
  SKIP_WITHOUT_SAMPLES();
  const auto replay = ValueOf(Read("csv/ecl_iris_gps.csv"));
  EXPECT_EQ(replay.imu.size(), 7062u);
  EXPECT_EQ(replay.gnss.size(), 169u);
  EXPECT_NEAR(replay.gnss.at(0).position.lat_deg, 47.3977508, 1e-9);
  const auto geotag = ValueOf(Read("csv/exiftool_geotag_dji.csv"));
  EXPECT_EQ(geotag.format, "tolerant_csv");
  EXPECT_NEAR(geotag.gnss.at(0).position.lat_deg, -44.69009395, 1e-9);
  EXPECT_FALSE(geotag.mapping.empty());
  const auto geoinfo = ValueOf(Read("csv/snowpeak_geoinfo.txt"));
  EXPECT_EQ(geoinfo.format, "sensefly_geoinfo");
  EXPECT_EQ(*geoinfo.events.at(0).image_name, "IMG_2166.JPG");
}

TEST(SampleLogs, EveryGroundControlListIsRead) {
  SKIP_WITHOUT_SAMPLES();
  int lists = 0, without_heights = 0;
  for (const auto& entry :
       std::filesystem::directory_iterator(std::filesystem::path(testing::SampleLogsFolder()) / "gcp")) {
    const auto list = ReadGcpList({entry.path().filename().string(), entry.path()});
    ASSERT_TRUE(list.ok()) << entry.path();
    EXPECT_FALSE(list->sightings.empty());
    const bool fills_heights = !list->points.front().height_m;  // with zeros, as one of the lists does
    ASSERT_EQ(list->warnings.size(), fills_heights ? 1u : 0u) << entry.path();
    if (fills_heights) {
      EXPECT_EQ(list->warnings[0].code, RemarkCode::kHeightsNotSurveyed);
      ++without_heights;
    }
    EXPECT_EQ(ErrorOf(ReadLog({entry.path().filename().string(), entry.path()})).code,
              ErrorCode::kUnsupportedFormat);
    ++lists;
  }
  EXPECT_EQ(lists, 8);
  EXPECT_EQ(without_heights, 1);
}

}  // namespace
}  // namespace skyquilt::flight
