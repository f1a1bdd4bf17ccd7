#include <gtest/gtest.h>

#include "core/flight/bytes/gps_time.h"
#include "core/flight/logs/explain_unknown.h"
#include "core/flight/logs/formats.h"
#include "core/flight/logs/log_builder.h"
#include "core/flight/logs/read_log.h"
#include "core/flight/logs/texts/gcp_list.h"
#include "core/flight/remarks/because.h"
#include "core/flight/remarks/remark_words.h"
#include "tests/support/value_of.h"

namespace skyquilt::flight {
namespace {

using geo::DegToRad;
using test::ErrorOf;
using test::ValueOf;

TEST(ParseDjiMrk, ReadsExposuresWithTheirSequence) {
  const std::string text =
      "7\t296288.242869\t[2211]\t     3,N\t     0,E\t    "
      "75,V\t47.6436873208,Lat\t16.4759271684,Lon\t512.998,Ellh\t"
      "0.014391, 0.013698, 0.029694\t50,Q\r\n"
      "9\t296289.777625\t[2211]\t     5,N\t     1,E\t    75,V\t0.0,Lat\t0.0,Lon\t0.0,Ellh\t1, 1, 1\t0,Q\r\n"
      "broken row\r\n";
  ASSERT_TRUE(LooksLikeDjiMrk(BytesOf(text)));
  const auto log = ValueOf(ParseDjiMrk("a.MRK", BytesOf(text)));
  ASSERT_EQ(log.events.size(), 2u);
  EXPECT_EQ(*log.events[0].sequence, 7);
  EXPECT_DOUBLE_EQ(log.events[0].t_s, 0.0);
  EXPECT_NEAR(log.events[1].t_s, 1.534756, 1e-6);
  EXPECT_DOUBLE_EQ(log.events[0].position->lat_deg, 47.6436873208);
  EXPECT_DOUBLE_EQ(*log.events[0].height_ellipsoid_m, 512.998);
  EXPECT_DOUBLE_EQ((*log.events[0].sigma_in_ned_m)[2], 0.029694);
  EXPECT_TRUE(log.events[0].is_rtk_fixed);
  EXPECT_FALSE(log.events[1].position.has_value()) << "no fix";
  EXPECT_EQ(*log.utc_at_zero, *UtcFromCivil(2022, 5, 25, 10, 17, 50.242869));
  EXPECT_EQ(log.warnings.size(), 1u);
}

TEST(ParseDjiMrk, TakesNoTableOfNineNumbersForOne) {
  const std::string row = "1\t0\t3\t22\t15.0\t0\t0\t0\t46.8\t7.1\t60.0\t1\n";
  EXPECT_FALSE(LooksLikeDjiMrk(BytesOf(row + row)));
  // Without brackets its cells still say what they are.
  EXPECT_TRUE(LooksLikeDjiMrk(
      BytesOf("7\t296288.2\t2211\t3,N\t0,E\t75,V\t47.6,Lat\t16.4,Lon\t512.9,Ellh\t0.1, 0.1, 0.2\t50,Q\n")));
}

std::string Srt(const std::string& body) {
  return "1\n00:00:01,500 --> 00:00:02,000\n" + body + "\n\n2\n00:00:02,500 --> 00:00:03,000\n" + body + "\n";
}

TEST(ParseDjiSrt, KnowsThatTheOrderOfCoordinatesDependsOnTheDialect) {
  const auto old_order =
      ValueOf(ParseDjiSrt("a.srt", BytesOf(Srt("GPS(149.0251,-20.2533,16) BAROMETER:1.9"))));
  EXPECT_DOUBLE_EQ(old_order.gnss.at(0).position.lat_deg, -20.2533);
  EXPECT_DOUBLE_EQ(old_order.gnss.at(0).position.lon_deg, 149.0251);
  EXPECT_DOUBLE_EQ(old_order.baro.at(0).height_above_takeoff_m, 1.9);
  EXPECT_DOUBLE_EQ(old_order.gnss.at(0).t_s, 1.5);
  EXPECT_GT(*old_order.gnss.at(0).sigma_horizontal_m, 3.0) << "four decimals are steps of 11 m";
  const auto matrice =
      ValueOf(ParseDjiSrt("b.srt", BytesOf(Srt("GPS(36.6146,-6.1120,0.0M) BAROMETER:0.3M"))));
  EXPECT_DOUBLE_EQ(matrice.gnss.at(0).position.lat_deg, 36.6146);
  EXPECT_DOUBLE_EQ(matrice.gnss.at(0).position.lon_deg, -6.1120);
}

TEST(ParseDjiSrt, ReadsBracketedValuesAndBothHeights) {
  const std::string text =
      "\xEF\xBB\xBF" + Srt("<font size=\"28\">FrameCnt: 1, DiffTime: 33ms\n2023-01-02 03:04:05.678\n"
                           "[latitude : 41.424724] [longtitude : 2.234156] [rel_alt: 12.500 abs_alt: "
                           "117.250] [gb_yaw: 45.0 gb_pitch: -90.0 gb_roll: 0.0]</font>");
  const auto log = ValueOf(ParseDjiSrt("c.srt", BytesOf(text)));
  EXPECT_DOUBLE_EQ(log.gnss.at(0).position.lon_deg, 2.234156);
  EXPECT_DOUBLE_EQ(*log.gnss.at(0).height_amsl_m, 117.25);
  EXPECT_LT(*log.gnss.at(0).sigma_horizontal_m, 2.1);
  EXPECT_DOUBLE_EQ(log.baro.at(0).height_above_takeoff_m, 12.5);
  ASSERT_EQ(log.gimbal.size(), 2u);
  EXPECT_NEAR(log.gimbal[0].ned_from_body.toRotationMatrix()(2, 0), 1.0, 1e-9)
      << "the optical axis points down";
  EXPECT_FALSE(log.utc_at_zero.has_value()) << "a local clock is not UTC";
  ASSERT_TRUE(log.local_at_zero.has_value());
  // Both subtitles carry one stamp here, at 1.5 s and at 2.5 s.
  EXPECT_LE(*log.local_at_zero, *UtcFromCivil(2023, 1, 2, 3, 4, 4.178));
  EXPECT_GE(*log.local_at_zero, *UtcFromCivil(2023, 1, 2, 3, 4, 3.178));
}

TEST(ParseDjiSrt, ReadsAirframeAndGimbalAngles) {
  const auto log = ValueOf(ParseDjiSrt(
      "d.srt",
      BytesOf(Srt("F/5.6, GPS (-58.851745, -34.237922, 15), H 85.80m, H.S 0.00m/s, F.PRY (2.7\xC2\xB0, "
                  "-7.0\xC2\xB0, 110.1\xC2\xB0), G.PRY (-24.4\xC2\xB0, 0.0\xC2\xB0, 110.4\xC2\xB0)"))));
  const Eigen::Vector3d airframe = YawPitchRollFromNed(log.attitude.at(0).ned_from_body);
  EXPECT_NEAR(airframe[0], DegToRad(110.1), 1e-9);
  EXPECT_NEAR(airframe[1], DegToRad(2.7), 1e-9);
  EXPECT_NEAR(airframe[2], DegToRad(-7.0), 1e-9);
  EXPECT_NEAR(YawPitchRollFromNed(log.gimbal.at(0).ned_from_body)[1], DegToRad(-24.4), 1e-9);
  EXPECT_DOUBLE_EQ(log.baro.at(0).height_above_takeoff_m, 85.8);
}

TEST(ParseDjiSrt, SaysWhenThereIsNoPosition) {
  EXPECT_EQ(ErrorOf(ParseDjiSrt("e.srt", BytesOf(Srt("ISO:100 Shutter:60")))).code, ErrorCode::kNoPosition);
  EXPECT_FALSE(ParseDjiSrt("f.srt", {}).ok());
}

TEST(ParseGeoTxt, ReadsProjectedAndGeographicSystems) {
  const std::string utm =
      "WGS84 UTM 16N\r\nDJI_0001.JPG 609925.8180680283 4950688.771811823 171.66 92.5 1.5 NaN\n";
  const auto log = ValueOf(ParseGeoTxt("geo.txt", BytesOf(utm)));
  EXPECT_NEAR(log.events.at(0).position->lat_deg, 44.701146315, 1e-8) << "by Krueger's series";
  EXPECT_NEAR(log.events.at(0).position->lon_deg, -85.612468690, 1e-8);
  EXPECT_FALSE(log.events.at(0).yaw_pitch_roll_rad.has_value()) << "an angle is missing";
  EXPECT_FALSE(log.events.at(0).has_time);
  const std::string geographic = "EPSG:4326\nb.jpg 16.5 47.5 400 10 0 -5 0.02 0.03\n";
  const auto degrees = ValueOf(ParseGeoTxt("geo.txt", BytesOf(geographic)));
  EXPECT_DOUBLE_EQ(degrees.events.at(0).position->lat_deg, 47.5) << "longitude comes first";
  EXPECT_NEAR((*degrees.events.at(0).yaw_pitch_roll_rad)[2], DegToRad(-5.0), 1e-12);
  EXPECT_EQ(degrees.events.at(0).attitude_kind, AttitudeKind::kAirframe);
  EXPECT_DOUBLE_EQ((*degrees.events.at(0).sigma_in_ned_m)[2], 0.03);
}

TEST(ParseGcpList, JoinsSightingsOfOnePoint) {
  const std::string text =
      "EPSG:4326\n16.47592207\t47.64350399\t463.662\t2501.09\t2452.00\tMAX_0029.JPG\tA\n"
      "16.47592207\t47.64350399\t463.662\t3185.96\t2514.86\tMAX_0142.JPG\tA\n"
      "16.47619479 47.64346579 461.732 2664.61 2773.97 MAX_0146.JPG B\nnonsense row\n";
  ASSERT_TRUE(LooksLikeGcpList(BytesOf(text)));
  EXPECT_FALSE(LooksLikeGeoTxt(BytesOf(text)));
  const auto list = ValueOf(ParseGcpList("gcp_list.txt", BytesOf(text)));
  ASSERT_EQ(list.points.size(), 2u);
  ASSERT_EQ(list.sightings.size(), 3u);
  EXPECT_EQ(list.points[1].name, "B");
  EXPECT_EQ(list.sightings[2].point, 1u);
  EXPECT_DOUBLE_EQ(list.points[0].position.lat_deg, 47.64350399);
  EXPECT_EQ(list.warnings.size(), 1u);
}

// As surveyors' programs and spreadsheets write them.
TEST(ParseGcpList, ReadsRowsBelowNamesOfColumnsHoweverTheyAreCut) {
  for (const std::string& text :
       {std::string("EPSG:32615\r\nx\ty\tz\tim_x\tim_y\timage\tname\r\n"
                    "576691.665\t5188169.628\t158.5\t297.01\t377.82\tA.JPG\tgcp1\r\n"),
        std::string("EPSG:32615+5773\n576691.665,5188169.628,158.5,297.01,377.82,A.JPG,gcp1\n"),
        std::string("wgs84 utm zone 15 north\n576691,665;5188169,628;158,5;297,01;377,82;A.JPG;gcp1\n"),
        std::string("EPSG:32615\nnorthing easting z px py image name\n"
                    "5188169.628 576691.665 158.5 297.01 377.82 A.JPG gcp1\n"),
        std::string("PROJCS[\"WGS 84 / UTM zone 15N\",\n GEOGCS[\"WGS 84\",DATUM[\"WGS_1984\",\n"
                    "SPHEROID[\"WGS 84\",6378137,298.257223563]],PRIMEM[\"Greenwich\",0],\n"
                    "UNIT[\"degree\",0.0174532925199433]],PROJECTION[\"Transverse_Mercator\"],\n"
                    "PARAMETER[\"latitude_of_origin\",0],PARAMETER[\"central_meridian\",-93],\n"
                    "PARAMETER[\"scale_factor\",0.9996],PARAMETER[\"false_easting\",500000],\n"
                    "PARAMETER[\"false_northing\",0],UNIT[\"metre\",1]]\n"
                    "576691.665 5188169.628 158.5 297.01 377.82 A.JPG gcp1\n")}) {
    ASSERT_TRUE(LooksLikeGcpList(BytesOf(text))) << text;
    const auto list = ValueOf(ParseGcpList("gcp_list.txt", BytesOf(text)));
    ASSERT_EQ(list.points.size(), 1u) << text;
    EXPECT_EQ(list.points[0].name, "gcp1") << text;
    EXPECT_NEAR(list.points[0].position.lat_deg, 46.84265, 1e-4) << text;
    EXPECT_NEAR(list.points[0].position.lon_deg, -91.99418, 1e-4) << text;
    EXPECT_DOUBLE_EQ(*list.points[0].height_m, 158.5) << text;
    ASSERT_EQ(list.sightings.size(), 1u) << text;
    EXPECT_DOUBLE_EQ(list.sightings[0].pixel_y, 377.82) << text;
  }
}

TEST(ParseGcpList, ReadsHeightsInTheUnitThatTheirColumnNames) {
  for (const char* name : {"z (ft)", "Elevation_ft"}) {
    const std::string text = "EPSG:32615\nx,y," + std::string(name) +
                             ",px,py,image\n576691.665,5188169.628,500,297.01,377.82,A.JPG\n";
    const auto list = ValueOf(ParseGcpList("gcp_list.txt", BytesOf(text)));
    EXPECT_NEAR(list.points.at(0).height_m.value_or(0.0), 152.4, 1e-9) << name;
  }
}

TEST(ParseGcpList, AsksForASystemThatIsMissingOrUnknown) {
  const std::string without = "576691.665 5188169.628 158.5 297.01 377.82 A.JPG gcp1\n";
  ASSERT_TRUE(LooksLikeGcpList(BytesOf(without)));
  const Error refused = ErrorOf(ParseGcpList("gcp_list.txt", BytesOf(without)));
  EXPECT_NE(refused.message.find("EPSG:32632"), std::string::npos) << refused.message;
  EXPECT_EQ(WhyOf(refused).code, RemarkCode::kPointsNameNoSystem);
  EXPECT_FALSE(ValueOf(ParseWrittenGcpList("gcp_list.txt", BytesOf(without))).points.at(0).has_position);
  const std::string unknown = "EPSG:99999\n" + without;
  ASSERT_TRUE(LooksLikeGcpList(BytesOf(unknown)));
  EXPECT_NE(ParseGcpList("gcp_list.txt", BytesOf(unknown)).error().message.find("\"EPSG:99999\""),
            std::string::npos);
}

TEST(ParseGcpList, IsNoTableOfALog) {
  for (const char* text : {"time_s,lat,lon,alt,speed,photo\n1.0,47.5,8.5,500,5,A.JPG\n",
                           "1.0,47.5,8.5,500,5,AUTO\n2.0,47.5,8.5,500,5,AUTO\n"}) {
    EXPECT_FALSE(LooksLikeGcpList(BytesOf(text))) << text;
    EXPECT_FALSE(LooksLikeGeoTxt(BytesOf(text))) << text;
  }
}

TEST(ParseGeoTxt, LeavesColumnsInAnotherPlaceToTheReaderOfNames) {
  const std::string timed =
      "image time lat lon alt\na.jpg 12:00:05 46.8 8.1 500\nb.jpg 12:00:07 46.9 8.1 500\n";
  EXPECT_FALSE(LooksLikeGeoTxt(BytesOf(timed)));
  const std::string height_first = "image alt lat lon\na.jpg 500 46.8 8.1\nb.jpg 500 46.9 8.1\n";
  EXPECT_FALSE(LooksLikeGeoTxt(BytesOf(height_first)));
  const std::string north_first = "image ycoordinate xcoordinate\na.jpg 46.8 8.1\nb.jpg 46.9 8.1\n";
  EXPECT_FALSE(LooksLikeGeoTxt(BytesOf(north_first)));
  for (const std::string& text : {timed, height_first, north_first}) {
    const auto log = ValueOf(ParseLog("list.txt", BytesOf(text)));
    ASSERT_EQ(log.events.size(), 2u) << text;
    ASSERT_TRUE(log.events[0].position) << text;
    EXPECT_DOUBLE_EQ(log.events[0].position->lat_deg, 46.8) << text;
    EXPECT_DOUBLE_EQ(log.events[0].position->lon_deg, 8.1) << text;
  }
}

TEST(ParseGeoTxt, TakesTheOrderOfTheHemispheresLetters) {
  const auto log = ValueOf(ParseGeoTxt("geo.txt", BytesOf("EPSG:4326\na.jpg N46.8 E8.1 500\n")));
  ASSERT_TRUE(log.events.at(0).position);
  EXPECT_DOUBLE_EQ(log.events.at(0).position->lat_deg, 46.8);
  EXPECT_DOUBLE_EQ(log.events.at(0).position->lon_deg, 8.1);
  const auto pix4d = ValueOf(ParsePix4dCsv("p.csv", BytesOf("a.jpg,E8.1,N46.8,500\n")));
  ASSERT_TRUE(pix4d.events.at(0).position);
  EXPECT_DOUBLE_EQ(pix4d.events.at(0).position->lat_deg, 46.8);
}

TEST(ParseGeoTxt, TakesNamesThatHoldBlanksAndQuotes) {
  const std::string text =
      "EPSG:4326\nDJI 0001.JPG 8.1 46.8 500\n\"IMG 2 (3).jpg\" 8.2 46.9 500\n\"c.jpg\" 8.3 47.0 500\n";
  ASSERT_TRUE(LooksLikeGeoTxt(BytesOf(text)));
  const auto log = ValueOf(ParseGeoTxt("geo.txt", BytesOf(text)));
  ASSERT_EQ(log.events.size(), 3u);
  EXPECT_EQ(log.events[0].image_name, "DJI 0001.JPG");
  EXPECT_EQ(log.events[1].image_name, "IMG 2 (3).jpg");
  EXPECT_EQ(log.events[2].image_name, "c.jpg");
  ASSERT_TRUE(log.events[1].position);
  EXPECT_DOUBLE_EQ(log.events[1].position->lat_deg, 46.9);
  EXPECT_EQ(log.events[1].height_ellipsoid_m, 500.0);
  const auto numbered = ValueOf(ParseGeoTxt("geo.txt", BytesOf("EPSG:4326\nIMG 1 (2).jpg 8.1 46.8\n")));
  EXPECT_EQ(numbered.events.at(0).image_name, "IMG 1 (2).jpg");
}

TEST(ParseGeoTxt, IsNoProseThatNamesAPicture) {
  for (const char* prose : {"Saved picture a.jpg 46.8 -91.9\n", "12:00:01 saved /DCIM/a.jpg 46.8 -91.9\n",
                            "Log of the day\nat 12 saved a.jpg 46.8 -91.9\n",
                            "uses EPSG:4326\nstarted\nSaved a.jpg 46.8 -91.9\n"})
    EXPECT_FALSE(LooksLikeGeoTxt(BytesOf(prose))) << prose;
  EXPECT_FALSE(LooksLikeGcpList(BytesOf("1.0 47.5 8.5 500 5 saved picture a.jpg\n")));
  EXPECT_TRUE(LooksLikeGeoTxt(BytesOf("\"DJI 1.jpg\" 8.1 46.8\n")));
  EXPECT_TRUE(LooksLikeGeoTxt(BytesOf("EPSG:4326\nDJI 1.jpg 8.1 46.8\n")));
}

TEST(ParseGcpList, TakesNamesThatHoldBlanks) {
  const auto list = ValueOf(ParseGcpList(
      "gcp_list.txt", BytesOf("EPSG:4326\n8.1 46.8 400 10 20 DJI 0001.JPG corner\n"
                              "8.2 46.8 400 30 40 \"IMG 2 (3).jpg\" pole\n8.2 46.8 400 50 60 DJI_7 pole\n"
                              "8.2 46.8 400 70 80 IMG 1 (2).jpg pole\n")));
  ASSERT_EQ(list.sightings.size(), 4u);
  EXPECT_EQ(list.sightings[3].image_name, "IMG 1 (2).jpg");
  EXPECT_EQ(list.sightings[0].image_name, "DJI 0001.JPG");
  EXPECT_EQ(list.sightings[1].image_name, "IMG 2 (3).jpg");
  EXPECT_EQ(list.sightings[2].image_name, "DJI_7");
  ASSERT_EQ(list.points.size(), 2u);
  EXPECT_EQ(list.points[0].name, "corner");
}

TEST(ParseGeoTxt, LeavesListsWithNamesOfColumnsToTheReaderOfNames) {
  const std::string text = "EPSG:4326\nimage lon lat alt roll pitch yaw\na.jpg 8.1 46.8 500 1 2 90\n";
  EXPECT_FALSE(LooksLikeGeoTxt(BytesOf(text)));
  const auto log = ValueOf(ParseLog("geo.txt", BytesOf(text)));
  ASSERT_TRUE(log.events.at(0).yaw_pitch_roll_rad);
  EXPECT_NEAR(log.events.at(0).yaw_pitch_roll_rad->x(), DegToRad(90.0), 1e-12);
  EXPECT_NEAR(log.events.at(0).yaw_pitch_roll_rad->z(), DegToRad(1.0), 1e-12);
  EXPECT_EQ(log.written_system, "EPSG:4326");
}

TEST(ParseGeoTxt, CountsHeightsOfACompoundSystemFromTheSea) {
  for (const char* system : {"EPSG:32615+5773", "urn:ogc:def:crs,crs:EPSG::32615,crs:EPSG::5773",
                             "urn:ogc:def:crs,crs:EPSG:9.8.5:32615,crs:EPSG:9.8.5:5773",
                             "CRS: http://www.opengis.net/def/crs-compound?1=http://www.opengis.net/def/crs/"
                             "EPSG/0/32615&2=http://www.opengis.net/def/crs/EPSG/0/5773"}) {
    const std::string text = std::string(system) + "\na.jpg 576667.1 5188164.6 198.3\n";
    ASSERT_TRUE(LooksLikeGeoTxt(BytesOf(text))) << system;
    const auto log = ValueOf(ParseGeoTxt("geo.txt", BytesOf(text)));
    ASSERT_TRUE(log.events.at(0).height_amsl_m) << system;
    EXPECT_DOUBLE_EQ(*log.events.at(0).height_amsl_m, 198.3) << system;
    EXPECT_FALSE(log.events.at(0).height_ellipsoid_m) << system;
    ASSERT_TRUE(log.events.at(0).position) << system;
    EXPECT_NEAR(log.events.at(0).position->lat_deg, 46.84261, 2e-5) << system;
  }
  // Not taken without the heights that it names.
  EXPECT_FALSE(ParseGeoTxt("geo.txt", BytesOf("urn:ogc:def:crs,crs:EPSG::32615,crs:OTHER::5773\n"
                                              "a.jpg 576667.1 5188164.6 198.3\n"))
                   .ok());
}

TEST(ParseGeoTxt, TakesHeightsThatAreAllZeroForNone) {
  const std::string rows = "EPSG:4326\na.jpg 8.1 46.8 0\nb.jpg 8.1 46.8 0\n";
  const auto flat = ValueOf(ParseGeoTxt("geo.txt", BytesOf(rows + "c.jpg 8.1 46.8 0.0\n")));
  ASSERT_EQ(flat.events.size(), 3u);
  for (const CameraEvent& event : flat.events) EXPECT_FALSE(event.height_ellipsoid_m);
  ASSERT_EQ(flat.warnings.size(), 1u);
  EXPECT_EQ(flat.warnings[0].code, RemarkCode::kHeightsNotSurveyed);
  const auto high = ValueOf(ParseGeoTxt("geo.txt", BytesOf(rows + "c.jpg 8.1 46.8 0.1\n")));
  EXPECT_EQ(high.events.at(0).height_ellipsoid_m, 0.0);
}

TEST(ParseGeoTxt, TakesAnglesThatAreAllZeroForNone) {
  const std::string rows =
      "EPSG:4326\na.jpg 8.1 46.8 500 0 0 0 0.02 0.03\nb.jpg 8.1 46.8 500 0 0 0 0.02 0.03\n";
  const auto filled = ValueOf(ParseGeoTxt("geo.txt", BytesOf(rows + "c.jpg 8.1 46.8 500 0 0 0 0.02 0.03\n")));
  ASSERT_EQ(filled.events.size(), 3u);
  for (const CameraEvent& event : filled.events) EXPECT_FALSE(event.yaw_pitch_roll_rad);
  ASSERT_TRUE(filled.events[0].sigma_in_ned_m);
  EXPECT_DOUBLE_EQ(filled.events[0].sigma_in_ned_m->x(), 0.02);
  ASSERT_EQ(filled.warnings.size(), 1u);
  EXPECT_EQ(filled.warnings[0].code, RemarkCode::kAnglesNotMeasured);
  const auto measured = ValueOf(ParseGeoTxt("geo.txt", BytesOf(rows + "c.jpg 8.1 46.8 500 0.1 0 0\n")));
  EXPECT_TRUE(measured.events.at(0).yaw_pitch_roll_rad);
}

TEST(ParseGeoTxt, TakesKappaForNoRoll) {
  const auto of_angles = [](const std::vector<const char*>& angles) {
    std::string text = "EPSG:4326\n";
    for (const char* row : angles) text += "a.jpg 8.1 46.8 500 " + std::string(row) + "\n";
    return ValueOf(ParseGeoTxt("geo.txt", BytesOf(text)));
  };
  const auto opk = of_angles({"1.5 -2 3", "0.5 1 -178", "-1 2 179", "2 1 358"});
  for (const CameraEvent& event : opk.events) EXPECT_FALSE(event.yaw_pitch_roll_rad);
  ASSERT_EQ(opk.warnings.size(), 1u);
  EXPECT_EQ(opk.warnings[0].code, RemarkCode::kAnglesWithoutHeader);
  for (const auto& flown : {of_angles({"90 2 3", "270 5 -10", "91 2 359"}),
                            of_angles({"10 -90 180", "5 -90 180", "8 -90 180"})}) {
    EXPECT_TRUE(flown.warnings.empty());
    for (const CameraEvent& event : flown.events) EXPECT_TRUE(event.yaw_pitch_roll_rad);
  }
}

TEST(ParseGeoTxt, KeepsWhatWasWrittenWhereItIsNoPlace) {
  const auto log = ValueOf(ParseGeoTxt("geo.txt", BytesOf("EPSG:4326\n\na.jpg 46.8 -91.9 198.3\n")));
  ASSERT_EQ(log.events.size(), 1u);
  EXPECT_FALSE(log.events[0].position);
  EXPECT_DOUBLE_EQ(log.events[0].written->x, 46.8);
  EXPECT_EQ(log.written_system, "EPSG:4326");
  const auto named =
      ValueOf(ParseLog("geo.txt", BytesOf("EPSG:4326\nimage latitude longitude\na.jpg 46.8 -91.9\n")));
  EXPECT_DOUBLE_EQ(named.events.at(0).position->lat_deg, 46.8) << "the names of the columns hold";
  const std::string bare = "a.jpg 576667.1 5188164.6 198.3\n";
  ASSERT_TRUE(LooksLikeGeoTxt(BytesOf(bare)));
  EXPECT_FALSE(ParseGeoTxt("geo.txt", BytesOf(bare))->events[0].position) << "no system is named";
  const Error unknown = ErrorOf(ParseGeoTxt("geo.txt", BytesOf("my own grid\na.jpg 1 2 3\n")));
  EXPECT_NE(unknown.message.find("\"my own grid\""), std::string::npos);
  EXPECT_EQ(WhyOf(unknown).code, RemarkCode::kSystemUnknown);
}

TEST(NamedPlaces, ReadsTheTwoCoordinatesOfPix4dAsItsHeaderNamesThem) {
  const std::string east_first = "image,longitude,latitude,altitude\na.jpg,8.5,47.4,500\n";
  ASSERT_TRUE(LooksLikeNamedPlaces(BytesOf(east_first)));
  const auto log = ValueOf(ParseLog("p.csv", BytesOf(east_first)));
  EXPECT_DOUBLE_EQ(log.events.at(0).position->lat_deg, 47.4);
  EXPECT_TRUE(log.written_order_is_named);
  const std::string projected = "#imagename,coordinate1,coordinate2,z\na.jpg,576667.1,5188164.6,198.3\n";
  ASSERT_TRUE(LooksLikeNamedPlaces(BytesOf(projected)));
  EXPECT_FALSE(LooksLikePix4dCsv(BytesOf(projected))) << "that is for lists without names alone";
  const auto metres = ValueOf(ParseLog("p.csv", BytesOf(projected)));
  EXPECT_FALSE(metres.events.at(0).position);
  EXPECT_DOUBLE_EQ(metres.events.at(0).written->x, 576667.1);
  EXPECT_FALSE(metres.written_order_is_assumed);
  const auto open =
      ValueOf(ParseLog("p.csv", BytesOf("image,coordinate1,coordinate2,z\na.jpg,8.5,47.4,500\n")));
  EXPECT_TRUE(open.written_order_is_assumed);
}

TEST(ExplainUnknownList, NamesTheCellThatIsNoNumber) {
  const auto why = [](const char* text) {
    return InWords(ExplainUnknownList(BytesOf(text), "list.txt").value_or(""));
  };
  EXPECT_NE(why("EPSG:4326\na.jpg here 46.8\n").find("column 2 of line 2 is no number: \"here\""),
            std::string::npos);
  EXPECT_NE(why("EPSG:32632\n1 2 3 4 five a.jpg\n").find("column 5 of line 2"), std::string::npos);
  EXPECT_NE(why("a.jpg,46.8\n").find("column 3 of line 1 is missing"), std::string::npos);
  EXPECT_EQ(why("notes of the day\nwind from the west\n"), "");
  EXPECT_NE(why("DJI 0001.JPG 8.1 46.8\n").find("\"DJI 0001.JPG\" in line 1 holds blanks"),
            std::string::npos);
}

TEST(ParseGcpList, KeepsPointsThatNoPhotoIsMarkedWithAndNamesWithBlanks) {
  const std::string text =
      "EPSG:32611\n340000.5\t3810000.25\t12.5\t10\t20\tDJI 0001.JPG\tcorner of the shed\n"
      "340010\t3810010\tnan\t0\t0\t-\tunmarked\n340020 3810020 13 0 0 - third\n";
  ASSERT_TRUE(LooksLikeGcpList(BytesOf(text)));
  const auto list = ValueOf(ParseGcpList("gcp_list.txt", BytesOf(text)));
  EXPECT_TRUE(list.warnings.empty());
  ASSERT_EQ(list.points.size(), 3u);
  EXPECT_EQ(list.points[0].name, "corner of the shed");
  EXPECT_EQ(list.points[0].x, 340000.5);
  EXPECT_EQ(list.points[0].y, 3810000.25);
  EXPECT_EQ(list.points[0].height, 12.5);
  EXPECT_FALSE(list.points[1].height);
  EXPECT_EQ(list.points[2].name, "third");
  ASSERT_EQ(list.sightings.size(), 1u);
  EXPECT_EQ(list.sightings[0].image_name, "DJI 0001.JPG");
  const auto unmarked = ValueOf(ParseGcpList("gcp_list.txt", BytesOf("EPSG:4326\n7.1 46.8 500 0 0 - a\n")));
  EXPECT_TRUE(unmarked.sightings.empty());
}

TEST(ParseGcpList, ReadsEastingsWithTheirZoneBeforeThem) {
  const std::string plain = "EPSG:25832\n521000 5412000 300 10 20 A.JPG\n";
  const std::string zoned = "EPSG:25832\n32521000 5412000 300 10 20 A.JPG\n";
  const auto one = ValueOf(ParseGcpList("gcp_list.txt", BytesOf(plain)));
  const auto other = ValueOf(ParseGcpList("gcp_list.txt", BytesOf(zoned)));
  ASSERT_EQ(other.points.size(), 1U);
  EXPECT_DOUBLE_EQ(other.points[0].position.lat_deg, one.points.at(0).position.lat_deg);
  EXPECT_DOUBLE_EQ(other.points[0].position.lon_deg, one.points.at(0).position.lon_deg);
}

TEST(ParseGcpList, ConvertsHeightsWithTheUnitOfTheSystem) {
  const std::string text =
      "EPSG:2251\n26607594.75468351 -26813.882366498266 563.1987598425 1331 350 DJI_0002.JPG\n";
  const auto list = ValueOf(ParseGcpList("gcp_list.txt", BytesOf(text)));
  EXPECT_NEAR(*list.points.at(0).height_m, 171.663, 0.001) << "international feet";
  EXPECT_NEAR(list.points.at(0).position.lat_deg, 44.7, 0.1);
}

TEST(NamedPlaces, UsesAnglesOnlyWhereTheHeaderNamesThem) {
  const std::string named =
      "#imagename,latitude [decimal degrees],longitude [decimal degrees],altitude [meter],yaw "
      "[degrees],pitch "
      "[degrees],roll [degrees],accuracy horizontal [meter],accuracy vertical "
      "[meter]\na.jpg,47.5,8.5,500,90,1,2,0.5,1.5\n";
  ASSERT_TRUE(LooksLikeNamedPlaces(BytesOf(named)));
  const auto log = ValueOf(ParseLog("p.csv", BytesOf(named)));
  EXPECT_NEAR((*log.events.at(0).yaw_pitch_roll_rad)[0], DegToRad(90.0), 1e-12);
  EXPECT_DOUBLE_EQ((*log.events.at(0).sigma_in_ned_m)[2], 1.5);
  const auto bare = ValueOf(ParsePix4dCsv("p.csv", BytesOf("a.jpg,47.5,8.5,500,90,1,2\n")));
  EXPECT_FALSE(bare.events.at(0).yaw_pitch_roll_rad.has_value());
  EXPECT_EQ(bare.warnings.size(), 1u);
}

TEST(NamedPlaces, TurnsOmegaPhiKappaIntoAnglesOfTheAirframe) {
  // Looking straight down with the image's top to the north is (0, 0, 0) in both; kappa counts the other way
  // round.
  const auto log =
      ValueOf(ParseLog("p.csv", BytesOf("image,latitude,longitude,altitude,omega,phi,kappa\na.jpg,"
                                        "47.5,8.5,500,0,0,0\nb.jpg,47.5,8.5,500,0,0,-92.5\n"
                                        "c.jpg,47.5,8.5,500,10,0,0\n")));
  EXPECT_LT(log.events.at(0).yaw_pitch_roll_rad->norm(), 1e-12);
  EXPECT_NEAR((*log.events.at(1).yaw_pitch_roll_rad)[0], DegToRad(92.5), 1e-12);
  // Omega turns the camera about the east axis: its view, (0, 0, -1), leans north; the nose of the airframe
  // rises.
  EXPECT_NEAR((*log.events.at(2).yaw_pitch_roll_rad)[1], DegToRad(10.0), 1e-12);
}

TEST(ParseSenseflyGeoinfo, ReadsBothHeights) {
  const std::string text =
      "#Rev: "
      "sensefly/geoinfo/"
      "2\nfileName\tlatitude\tlongitude\taltitude_amsl\taltitude_wgs84\theading\tpitch\troll\n"
      "IMG_2166.JPG\t37.5448893\t139.0398406\t216.59\t255.84\t149.5\t5.25\t-3.75\n";
  ASSERT_TRUE(LooksLikeSenseflyGeoinfo(BytesOf(text)));
  const auto log = ValueOf(ParseSenseflyGeoinfo("geoinfo.txt", BytesOf(text)));
  EXPECT_DOUBLE_EQ(*log.events.at(0).height_amsl_m, 216.59);
  EXPECT_DOUBLE_EQ(*log.events.at(0).height_ellipsoid_m, 255.84);
  EXPECT_NEAR((*log.events.at(0).yaw_pitch_roll_rad)[2], DegToRad(-3.75), 1e-12);
}

TEST(ParseGpx, ReadsTimedPointsOnly) {
  const std::string text =
      "<?xml version=\"1.0\"?><gpx><trk><trkseg><trkpt lat=\"47.5\" "
      "lon='8.5'><ele>400.5</ele><time>2021-06-01T10:00:00Z</time>"
      "</trkpt>\n<trkpt lat=\"47.6\" lon=\"8.6\"/><trkpt lon=\"8.7\" "
      "lat=\"47.7\"><time>2021-06-01T10:00:02.5Z</time></trkpt>"
      "</trkseg></trk></gpx>";
  ASSERT_TRUE(LooksLikeGpx(BytesOf(text)));
  const auto log = ValueOf(ParseGpx("a.gpx", BytesOf(text)));
  ASSERT_EQ(log.gnss.size(), 2u);
  EXPECT_DOUBLE_EQ(log.gnss[1].t_s, 2.5);
  EXPECT_DOUBLE_EQ(log.gnss[1].position.lat_deg, 47.7);
  EXPECT_DOUBLE_EQ(*log.gnss[0].height_amsl_m, 400.5);
  EXPECT_EQ(*log.utc_at_zero, *UtcFromCivil(2021, 6, 1, 10, 0, 0.0));
  EXPECT_EQ(log.warnings.size(), 1u);
}

TEST(ParseNmea, JoinsSentencesAcrossMidnightAndChecksThem) {
  const std::string text =
      "$GPRMC,235959.00,A,4730.0000,N,00830.0000,W,0.1,90.0,310521,,,A*7A\r\n"
      "$GPGGA,235959.00,4730.0000,N,00830.0000,W,4,12,0.7,400.5,M,48.25,M,1.0,0*50\r\n"
      "$GPGST,235959.00,,,,,0.02,0.03,0.05*62\r\n"
      "$GPGGA,000000.00,4730.0006,N,00830.0000,W,1,12,0.7,401.5,M,48.25,M,,\r\n"
      "$GPGGA,000001.00,4730.0006,N,00830.0000,W,1,12,0.7,401.5,M,48.25,M,,*00\r\n";
  const auto log = ValueOf(ParseNmea("a.nmea", BytesOf(text)));
  ASSERT_EQ(log.gnss.size(), 2u) << "the last checksum is wrong";
  EXPECT_DOUBLE_EQ(log.gnss[0].position.lat_deg, 47.5);
  EXPECT_DOUBLE_EQ(log.gnss[0].position.lon_deg, -8.5);
  EXPECT_DOUBLE_EQ(*log.gnss[0].height_ellipsoid_m, 448.75);
  EXPECT_DOUBLE_EQ(*log.gnss[0].sigma_horizontal_m, 0.03);
  EXPECT_TRUE(log.gnss[0].is_rtk_fixed);
  EXPECT_DOUBLE_EQ(log.gnss[1].t_s, 1.0);
  EXPECT_EQ(*log.utc_at_zero, *UtcFromCivil(2021, 5, 31, 23, 59, 59.0));
}

}  // namespace
}  // namespace skyquilt::flight
