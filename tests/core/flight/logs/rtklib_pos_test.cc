// Solutions of RTKLIB and its kin (.pos).
#include <gtest/gtest.h>

#include <string>
#include <string_view>

#include "core/flight/bytes/gps_time.h"
#include "core/flight/logs/formats.h"
#include "core/flight/logs/read_log.h"
#include "core/geo/lat_lon.h"
#include "tests/support/value_of.h"

namespace skyquilt::flight {
namespace {

using test::ErrorOf;
using test::ValueOf;

TEST(ParseRtklibPos, ReadsItsCoordinateAndTimeForms) {
  const std::string dms =
      "% program   : RTKLIB ver.2.4.2\n%  GPST                          latitude(d'\")   longitude(d'\")  "
      "height(m)   Q  ns\n"
      "2005/04/02 00:00:00.000   -35 09 39.11744  139 36 49.83479    31.9009   1   7   0.0058   0.0044   "
      "0.0136 0 0 0 0 0\n";
  const auto log = ValueOf(ParseRtklibPos("a.pos", BytesOf(dms)));
  EXPECT_NEAR(log.gnss.at(0).position.lat_deg, -(35.0 + 9.0 / 60.0 + 39.11744 / 3600.0), 1e-12);
  EXPECT_TRUE(log.gnss.at(0).is_rtk_fixed);
  EXPECT_DOUBLE_EQ(*log.gnss.at(0).sigma_horizontal_m, 0.0058);
  EXPECT_EQ(*log.utc_at_zero, *UtcFromCivil(2005, 4, 1, 23, 59, 47.0)) << "GPS time was 13 s ahead";
  const std::string weeks =
      "%  GPST          latitude(deg) longitude(deg)  height(m)   Q  ns\n1316 518400.000   35.160865956  "
      "139.613842997  31.9  2  7 1 2 3\n";
  const auto by_week = ValueOf(ParseRtklibPos("b.pos", BytesOf(weeks)));
  EXPECT_EQ(*by_week.utc_at_zero, *log.utc_at_zero);
  EXPECT_FALSE(by_week.gnss.at(0).is_rtk_fixed);
  // Told to write UTC, it counts weeks of that.
  std::string utc_weeks = weeks;
  utc_weeks.replace(utc_weeks.find("GPST"), 4, "UTC ");
  const auto by_utc_week = ValueOf(ParseRtklibPos("u.pos", BytesOf(utc_weeks)));
  EXPECT_EQ(*by_utc_week.utc_at_zero, *UtcFromCivil(2005, 4, 2, 0, 0, 0.0));
  const geo::Wgs84 place{35.16, 139.61, 31.9};
  const Eigen::Vector3d ecef = geo::EcefFromWgs84(place);
  const std::string text =
      "%  UTC   x-ecef(m)      y-ecef(m)      z-ecef(m)   Q  ns\n2005/04/02 00:00:00.000 " +
      std::to_string(ecef.x()) + " " + std::to_string(ecef.y()) + " " + std::to_string(ecef.z()) +
      " 5 7 1 1 1\n";
  const auto by_ecef = ValueOf(ParseRtklibPos("c.pos", BytesOf(text)));
  EXPECT_NEAR(by_ecef.gnss.at(0).position.lat_deg, 35.16, 1e-9);
  EXPECT_EQ(*by_ecef.utc_at_zero, *UtcFromCivil(2005, 4, 2, 0, 0, 0.0));
}

TEST(ParseRtklibPos, TakesHeightsTimesAndOriginsAsItsHeaderSays) {
  const auto japan = ValueOf(ParseRtklibPos(
      "a.pos", BytesOf("% (lat/lon/height=WGS84/geodetic,Q=1:fix,2:float)\n"
                       "%  JST                  latitude(deg) longitude(deg)  height(m)   Q  ns\n"
                       "2005/04/02 09:00:00.000   35.160865956  139.613842997  31.9  1  7 1 2 3\n")));
  EXPECT_EQ(*japan.utc_at_zero, *UtcFromCivil(2005, 4, 2, 0, 0, 0.0));
  EXPECT_EQ(japan.gnss.at(0).height_amsl_m, 31.9);
  EXPECT_FALSE(japan.gnss.at(0).height_ellipsoid_m);
  const auto in_a_folder = ValueOf(ParseRtklibPos(
      "c.pos", BytesOf("% inp file  : /data/geodetic/site-baseline/e-baseline/r.obs\n"
                       "%  GPST                 latitude(deg) longitude(deg)  height(m)   Q  ns\n"
                       "2005/04/02 09:00:00.000   35.160865956  139.613842997  31.9  1  7 1 2 3\n")));
  EXPECT_EQ(in_a_folder.gnss.at(0).height_ellipsoid_m, 31.9);
  const std::string_view from_base =
      "%  GPST                 e-baseline(m)  n-baseline(m)  u-baseline(m)   Q  ns\n"
      "2005/04/02 00:00:00.000   12.34  -45.6  80.1  1  9\n";
  ASSERT_TRUE(LooksLikeRtklibPos(BytesOf(from_base)));
  const Error refused = ErrorOf(ParseRtklibPos("b.pos", BytesOf(from_base)));
  EXPECT_EQ(refused.code, ErrorCode::kUnprocessable);
  EXPECT_NE(refused.message.find("metres from its base station"), std::string::npos);
}

// As its option "field separator" says.
TEST(ParseRtklibPos, TakesFieldsApartByCommasAndSemicolons) {
  const std::string blanks =
      "% program   : RTKLIB ver.2.4.3\n"
      "% (lat/lon/height=WGS84/ellipsoidal,Q=1:fix,2:float,ns=# of satellites)\n"
      "%  GPST                  SEP latitude(deg) SEPlongitude(deg) SEP height(m) SEP  Q SEP ns SEP  sdn(m)\n"
      "2005/04/02 00:00:00.000 SEP  35.160865956 SEP 139.613842997 SEP   31.9000 SEP  1 SEP  7 SEP  0.0058\n";
  for (const char* separator : {" ", ",", ";", "\t"}) {
    std::string text = blanks;
    for (std::size_t at = text.find("SEP"); at != std::string::npos; at = text.find("SEP"))
      text.replace(at, 3, separator);
    const auto log = ValueOf(ParseLog("a.pos", BytesOf(text)));
    EXPECT_EQ(log.format, "rtklib_pos") << text;
    ASSERT_EQ(log.gnss.size(), 1u) << text;
    EXPECT_DOUBLE_EQ(log.gnss[0].position.lat_deg, 35.160865956) << text;
    EXPECT_DOUBLE_EQ(log.gnss[0].position.lon_deg, 139.613842997) << text;
    EXPECT_EQ(log.gnss[0].height_ellipsoid_m, 31.9) << text;
    EXPECT_TRUE(log.gnss[0].is_rtk_fixed) << text;
    EXPECT_EQ(*log.utc_at_zero, *UtcFromCivil(2005, 4, 1, 23, 59, 47.0)) << text;
  }
}

// A comma is no separator below names that blanks keep apart: "46,84" is not 46 and 84.
TEST(ParseRtklibPos, TakesNoDecimalCommaForASeparator) {
  const std::string text =
      "%  GPST                 latitude(deg) longitude(deg)  height(m)   Q  ns\n"
      "2005/04/02 00:00:00.000  46,84  8,12  500,5  1  7\n";
  EXPECT_FALSE(ParseRtklibPos("a.pos", BytesOf(text)).ok());
}

}  // namespace
}  // namespace skyquilt::flight
