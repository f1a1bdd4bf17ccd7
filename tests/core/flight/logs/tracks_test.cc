#include <gmock/gmock.h>

#include "core/flight/logs/explain_unknown.h"
#include "core/flight/logs/formats.h"
#include "core/flight/logs/read_log.h"
#include "core/flight/logs/tracks/track_points.h"
#include "core/flight/logs/tracks/xml_scanner.h"
#include "core/flight/remarks/because.h"
#include "core/flight/remarks/remark_words.h"
#include "tests/support/value_of.h"

namespace skyquilt::flight {
namespace {

using test::ErrorOf;
using test::ValueOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

// Names as they open and close, with the words of what closes.
std::vector<std::string> TagsOf(std::string_view text) {
  std::vector<std::string> tags;
  XmlScanner xml(text);
  while (xml.Next())
    tags.push_back((xml.opens() ? "+" : "-") + std::string(xml.name()) +
                   (xml.opens() ? std::string() : ":" + std::string(xml.words())));
  return tags;
}

TEST(XmlScanner, TellsTagsAndWordsApart) {
  EXPECT_THAT(
      TagsOf(
          "<?xml version='1.0'?><!DOCTYPE a [<!ENTITY b \"c\">]>\n<x:a q='1>2'> <!-- <b>no</b> --><b >4&#50;"
          "<![CDATA[.<5]]>&amp;</b><c/></x:a>"),
      ElementsAre("+a", "+b", "-b:42.<5&", "+c", "-c:", "-a:"));
  EXPECT_THAT(TagsOf("<a <b>1</b> < </c"), ElementsAre("+b", "-b:1")) << "what is no tag is passed over";
  EXPECT_THAT(TagsOf("<a><b>" + std::string(1000, 'x') + "</b>"),
              ElementsAre("+a", "+b", "-b:" + std::string(256, 'x')));
  EXPECT_TRUE(TagsOf("<!-- <a>").empty());
  EXPECT_EQ(XmlRootName("\xEF\xBB\xBF <?xml?>\n<!-- x -->\n<k:kml xmlns:k='y'>"), "kml");
  EXPECT_EQ(XmlRootName("a <gpx>"), "");
}

TEST(TrackTime, TakesDatesAndCountsOfSeconds) {
  const UtcTime right = *UtcFromCivil(2016, 6, 23, 21, 31, 9.0);
  for (const char* text :
       {"2016-06-23T21:31:09Z", "2016-06-23T21:31:09.000Z", "2016-06-23T16:31:09-05:00",
        "2016-06-23 21:31:09", "1466717469", "1466717469000", "1466717469000000", "1.466717469e12"}) {
    const auto time = TrackTime(text);
    ASSERT_TRUE(time) << text;
    EXPECT_EQ(time->time, right) << text;
  }
  for (const char* text : {"", "21:31:09", "2016-06-23", "12", "nan", "1e300", "-1466717469"})
    EXPECT_FALSE(TrackTime(text)) << text;
}

TEST(ParseGpx, TakesHeightsThatAreAllZeroForUnknown) {
  const auto read = [](const char* last_height_m) {
    std::string text = "<gpx><trk><trkseg>";
    for (const std::string_view second : {"09", "10", "11"}) {
      const std::string height_m = second == "11" ? last_height_m : "0.0";
      text += "<trkpt lat='46.5' lon='7." + std::string(second) + "'><ele>" + height_m +
              "</ele><geoidheight>48</geoidheight><time>2016-06-23T21:31:" + std::string(second) +
              "Z</time></trkpt>";
    }
    text += "</trkseg></trk></gpx>";
    return ValueOf(ParseGpx("a.gpx", BytesOf(text)));
  };
  const auto flat = read("0");
  ASSERT_EQ(flat.gnss.size(), 3U);
  EXPECT_FALSE(flat.gnss[1].height_amsl_m);
  EXPECT_FALSE(flat.gnss[1].height_ellipsoid_m);
  ASSERT_EQ(flat.warnings.size(), 1U);
  EXPECT_EQ(flat.warnings[0].code, RemarkCode::kHeightsNotSurveyed);
  EXPECT_EQ(read("1.5").gnss.at(1).height_amsl_m, 0.0) << "by the sea";
}

TEST(ParseGpx, ReadsAnyPrefixQuoteAndOrder) {
  const std::string text =
      "<?xml version='1.0'?><gpx:gpx xmlns:gpx='http://www.topografix.com/GPX/1/1'><gpx:wpt lat='1' lon='1'>"
      "<gpx:time>2015-01-01T00:00:00Z</gpx:time></gpx:wpt><gpx:trk><gpx:trkseg>"
      "<!-- <gpx:trkpt lat='2' lon='2'> --><gpx:trkpt lon = '-91.5'\n lat=\"46,25\"><gpx:extensions><time>2001-01-01T00:"
      "00:00Z</time></gpx:extensions><gpx:time><![CDATA[2016-06-23T16:31:11.5-05:00]]></gpx:time>"
      "<gpx:ele>158.5</gpx:ele><gpx:geoidheight>-30.5</gpx:geoidheight></gpx:trkpt>"
      "<gpx:trkpt lat='46.5' lon='-91.25'><gpx:time>2016-06-23T21:31:09Z</gpx:time></gpx:trkpt></gpx:trkseg></gpx:trk>"
      "</gpx:gpx>";
  ASSERT_TRUE(LooksLikeGpx(BytesOf(text)));
  const auto log = ValueOf(ParseGpx("a.gpx", BytesOf(text)));
  ASSERT_EQ(log.gnss.size(), 2U) << "waypoints are no part of a track";
  EXPECT_DOUBLE_EQ(log.gnss[0].position.lat_deg, 46.5) << "in the order of time";
  EXPECT_DOUBLE_EQ(log.gnss[1].t_s, 2.5);
  EXPECT_DOUBLE_EQ(log.gnss[1].position.lat_deg, 46.25);
  EXPECT_DOUBLE_EQ(log.gnss[1].position.lon_deg, -91.5);
  EXPECT_DOUBLE_EQ(*log.gnss[1].height_amsl_m, 158.5);
  EXPECT_DOUBLE_EQ(*log.gnss[1].height_ellipsoid_m, 128.0);
  EXPECT_EQ(*log.utc_at_zero, *UtcFromCivil(2016, 6, 23, 21, 31, 9.0));
  EXPECT_TRUE(log.warnings.empty());
}

std::string GpxOf(const std::string& points) { return "<gpx>" + points + "</gpx>"; }

TEST(ParseGpx, TakesRoutesAndWaypointsWhereNoTrackHasTimes) {
  const std::string untimed = "<trk><trkseg><trkpt lat='1' lon='1'/></trkseg></trk>";
  const std::string route = "<rte><rtept lat='2' lon='2'><time>2016-06-23T21:31:09Z</time></rtept></rte>";
  const std::string waypoint = "<wpt lat='3' lon='3'><time>2016-06-23T21:31:09Z</time></wpt>";
  const auto by_route = ValueOf(ParseGpx("a.gpx", BytesOf(GpxOf(waypoint + untimed + route))));
  EXPECT_DOUBLE_EQ(by_route.gnss.at(0).position.lat_deg, 2.0);
  const auto by_waypoint = ValueOf(ParseGpx("a.gpx", BytesOf(GpxOf(untimed + waypoint))));
  EXPECT_DOUBLE_EQ(by_waypoint.gnss.at(0).position.lat_deg, 3.0);
}

TEST(ParseGpx, SaysWhatItsPointsLack) {
  const auto said = [](const std::string& points) {
    const auto log = ParseGpx("a.gpx", BytesOf(GpxOf(points)));
    if (log.ok()) return std::string("read");
    EXPECT_TRUE(HasReason(log.error())) << log.error().message;
    return log.error().message;
  };
  EXPECT_THAT(said(""), HasSubstr("no point"));
  EXPECT_THAT(said("<trkpt lat='1' lon='2'></trkpt><trkpt lat='1' lon='2'/>"),
              HasSubstr("2 points have no times"));
  EXPECT_THAT(said("<trkpt lat='1' lon='2'><time>23/06/2016 9 pm</time></trkpt>"),
              HasSubstr("\"23/06/2016 9 pm\""));
  EXPECT_THAT(said("<trkpt lat='576667.1' lon='5188164.6'><time>2016-06-23T21:31:09Z</time></trkpt>"),
              HasSubstr("none of its 1 points has a latitude and a longitude"));
}

TEST(ParseNmea, FindsSentencesBehindOtherWords) {
  const std::string text =
      "--------- beginning of main\n06-23 21:31:08.900 D GnssLocation: price $5\n"
      "06-23 21:31:09.000 D NMEA : $BDGGA,213109.00,4650.5564,N,09159.6736,W,1,12,0.7,158.5,M,-30.5,M,,\n"
      "06-23 21:31:09.001 D NMEA : $GLGGA,213109.00,4650.0000,N,09159.0000,W,1,12,0.7,159.5,M,-30.5,M,,\n"
      "06-23 21:31:09.002 D NMEA : $GNRMC,213109.00,A,4650.5564,N,09159.6736,W,4.0,45.0,230616,,,A*6A\n"
      "1466717470.0 $GNGNS,213110.00,4650.5570,N,09159.6736,W,RN,12,0.7,160.5,-30.5,,\n"
      "NMEA,$GPGGA,213111.00,4650.5580,N,09159.6736,W,1,12,0.7,161.5,M,-30.5,M,,*00,1466717471000\n";
  ASSERT_TRUE(LooksLikeNmea(BytesOf(text)));
  const auto log = ValueOf(ParseNmea("a.log", BytesOf(text)));
  ASSERT_EQ(log.gnss.size(), 2U) << "an epoch told twice counts once, one with a wrong checksum not at all";
  EXPECT_DOUBLE_EQ(*log.gnss[0].height_amsl_m, 158.5);
  EXPECT_DOUBLE_EQ(*log.gnss[1].height_ellipsoid_m, 130.0);
  EXPECT_TRUE(log.gnss[1].is_rtk_fixed);
  EXPECT_THAT(InWords(log.warnings), Contains(HasSubstr("wrong checksum")));
}

TEST(ParseNmea, ReadsPositionsOfRmcAlone) {
  const std::string text =
      "$GPRMC,213109.00,A,4650.5564,S,09159.6736,E,4.0,45.0,230616,,,A\n"
      "$GPRMC,213110.00,V,4650.5564,S,09159.6736,E,4.0,45.0,230616,,,N\n"
      "$GPRMC,213111.00,A,4650.5570,S,09159.6736,E,4.0,45.0,230616,,,A\n";
  const auto log = ValueOf(ParseNmea("a.nmea", BytesOf(text)));
  ASSERT_EQ(log.gnss.size(), 2U);
  EXPECT_NEAR(log.gnss[0].position.lat_deg, -46.84260667, 1e-8);
  EXPECT_FALSE(log.gnss[0].height_amsl_m);
  EXPECT_EQ(*log.utc_at_zero, *UtcFromCivil(2016, 6, 23, 21, 31, 9.0));
}

TEST(ParseNmea, QuotesTheFirstOfNothingButWrongChecksums) {
  const Error log = ErrorOf(ParseNmea(
      "a.nmea", BytesOf("$GPGGA,213109.00,4650.5564,N,09159.6736,W,1,12,0.7,158.5,M,-30.5,M,,*00\n")));
  EXPECT_THAT(log.message, HasSubstr("wrong checksum, first in line 1: \"$GPGGA,213109.00"));
}

TEST(ParseKml, ReadsTracksAndTimedPlacemarks) {
  const std::string text =
      "<?xml version='1.0'?><k:kml xmlns:k='a' xmlns:gx='b'><k:Document><k:Placemark><gx:Track><k:altitudeMode>absolute"
      "</k:altitudeMode><k:when>2016-06-23T21:31:09Z</k:when><k:when>2016-06-23T21:31:10Z</k:when><gx:coord>-91.5 46.25 "
      "198</gx:coord><gx:coord>-91.25 46.5 199</gx:coord></gx:Track></k:Placemark><k:Placemark><k:LookAt/><k:TimeStamp>"
      "<k:when>2016-06-23T21:31:12Z</k:when></k:TimeStamp><k:Point><k:altitudeMode>relativeToGround</k:altitudeMode>"
      "<k:coordinates>\n-91.0, 46.75,40 </k:coordinates></k:Point></k:Placemark></k:Document></k:kml>";
  ASSERT_TRUE(LooksLikeKml(BytesOf(text)));
  const auto log = ValueOf(ParseKml("a.kml", BytesOf(text)));
  ASSERT_EQ(log.gnss.size(), 3U);
  EXPECT_DOUBLE_EQ(log.gnss[1].position.lat_deg, 46.5);
  EXPECT_DOUBLE_EQ(*log.gnss[1].height_amsl_m, 199.0);
  EXPECT_DOUBLE_EQ(log.gnss[2].t_s, 3.0);
  EXPECT_FALSE(log.gnss[2].height_amsl_m);
  ASSERT_EQ(log.baro.size(), 1U);
  EXPECT_DOUBLE_EQ(log.baro[0].height_above_takeoff_m, 40.0);
}

TEST(ParseKml, AMultiTrackSaysWhatTheHeightsOfItsTracksCountFrom) {
  const std::string track =
      "<gx:Track><when>2016-06-23T21:31:09Z</when><gx:coord>-91.5 46.25 40</gx:coord></gx:Track>";
  const std::string later =
      "<gx:Track><when>2016-06-23T21:31:19Z</when><gx:coord>-91.5 46.25 198</gx:coord></gx:Track>";
  const auto log = ValueOf(ParseKml(
      "a.kml", BytesOf("<kml><Placemark><gx:MultiTrack><altitudeMode>relativeToGround</altitudeMode>" +
                       track + "</gx:MultiTrack></Placemark><Placemark>" + later + "</Placemark></kml>")));
  ASSERT_EQ(log.gnss.size(), 2U);
  EXPECT_FALSE(log.gnss[0].height_amsl_m);
  ASSERT_EQ(log.baro.size(), 1U);
  EXPECT_DOUBLE_EQ(log.baro[0].height_above_takeoff_m, 40.0);
  EXPECT_EQ(log.gnss[1].height_amsl_m, 198.0) << "a track by itself";
}

TEST(ParseKml, SaysThatLinesHaveNoTimes) {
  const Error line = ErrorOf(
      ParseKml("field.kml", BytesOf("<kml><Placemark><LineString><coordinates>8,47 8.1,47</coordinates>"
                                    "</LineString></Placemark></kml>")));
  EXPECT_THAT(line.message, HasSubstr("1 lines or areas, which have no times"));
  EXPECT_THAT(line.message, HasSubstr("--boundary"));
  const auto point = ParseKml(
      "a.kml", BytesOf("<kml><Placemark><Point><coordinates>8,47</coordinates></Point></Placemark></kml>"));
  EXPECT_THAT(point.error().message, HasSubstr("1 point has no times"));
}

std::string FeatureOf(const std::string& geometry, const std::string& properties) {
  return R"({"type":"FeatureCollection","features":[{"type":"Feature","geometry":)" + geometry +
         R"(,"properties":)" + properties + "}]}";
}

TEST(ParseGeoJson, ReadsTimesWhereverTheyStand) {
  const std::string line = R"({"type":"LineString","coordinates":[[-91.5,46.25,198],[-91.25,46.5,199]]})";
  const std::string two = R"(["2016-06-23T21:31:09Z","2016-06-23T21:31:10Z"])";
  for (
      const std::string& text :
      {FeatureOf(line, R"({"time":"2016-06-23T21:31:09Z","coordTimes":)" + two + "}"),
       FeatureOf(line, R"({"coordinateProperties":{"times":)" + two + "}}"),
       FeatureOf(line, R"({"timestamps":[1466717469000,1466717470000]})"),
       R"({"features":[{"properties":{"datetimes":)" + two + R"(},"geometry":)" + line +
           R"(,"type":"Feature"}]})",
       FeatureOf(
           R"({"type":"LineString","coordinates":[[-91.5,46.25,198,1466717469],[-91.25,46.5,199,1466717470]]})",
           "null"),
       FeatureOf(R"({"type":"MultiLineString","coordinates":[[[-91.5,46.25,198]],[[-91.25,46.5,199]]]})",
                 R"({"coordTimes":[["2016-06-23T21:31:09Z"],["2016-06-23T21:31:10Z"]]})"),
       std::string(R"({"type":"FeatureCollection","features":[)") +
           R"({"type":"Feature","properties":{"Date_Time":"2016-06-23T21:31:10Z"},"geometry":{"type":"Point","coordinates":[-91.25,46.5,199]}},)" +
           R"({"type":"Feature","properties":{"Date_Time":"2016-06-23T21:31:09Z"},"geometry":{"type":"Point","coordinates":[-91.5,46.25,198]}}]})"}) {
    ASSERT_TRUE(LooksLikeGeoJson(BytesOf(text))) << text;
    const auto log = ValueOf(ParseGeoJson("a.geojson", BytesOf(text)));
    ASSERT_EQ(log.gnss.size(), 2U) << text;
    EXPECT_DOUBLE_EQ(log.gnss[0].position.lat_deg, 46.25) << text;
    EXPECT_DOUBLE_EQ(log.gnss[1].position.lon_deg, -91.25) << text;
    EXPECT_DOUBLE_EQ(*log.gnss[1].height_amsl_m, 199.0) << text;
    EXPECT_DOUBLE_EQ(log.gnss[1].t_s, 1.0) << text;
    EXPECT_EQ(*log.utc_at_zero, *UtcFromCivil(2016, 6, 23, 21, 31, 9.0)) << text;
  }
}

TEST(ParseGeoJson, SaysWhyItIsNoTrack) {
  const auto said = [](const std::string& text) {
    const auto log = ParseGeoJson("a.geojson", BytesOf(text));
    if (log.ok()) return std::string("read");
    EXPECT_TRUE(HasReason(log.error())) << log.error().message;
    return log.error().message;
  };
  EXPECT_THAT(said(FeatureOf(R"({"type":"Point","coordinates":[8,47]})", "{}")),
              HasSubstr("1 point has no times"));
  EXPECT_THAT(said(FeatureOf(R"({"type":"LineString","coordinates":[[8,47],[8,47],[8,47]]})",
                             R"({"times":["2016-06-23T21:31:09Z","2016-06-23T21:31:10Z"]})")),
              HasSubstr("a line of 3 places has 2 times"));
  EXPECT_THAT(said(FeatureOf(R"({"type":"Point","coordinates":[8,47]})", R"({"time":"noon"})")),
              HasSubstr("\"noon\""));
  EXPECT_THAT(said(FeatureOf(R"({"type":"Polygon","coordinates":[[[8,47],[9,47],[9,48],[8,47]]]})", "{}")),
              HasSubstr("it holds areas"));
  EXPECT_THAT(said(R"({"type":"FeatureCollection","features":[)" + std::string(100, '[')),
              HasSubstr("nested"));
  EXPECT_THAT(said(R"({"type":"Feature",)"), HasSubstr("no JSON from byte"));
  EXPECT_FALSE(LooksLikeGeoJson(BytesOf(R"({"cameras":[1]})")));
}

TEST(ParseGeoJson, KeepsWhatStandsBeforeDamage) {
  const std::string whole =
      FeatureOf(R"({"type":"Point","coordinates":[8,47]})", R"({"time":"2016-06-23T21:31:09Z"})");
  const auto log = ValueOf(ParseGeoJson("a.geojson", BytesOf(whole.substr(0, whole.size() - 2) + ",{]}")));
  EXPECT_THAT(InWords(log.warnings), Contains(HasSubstr("damaged at byte")));
}

TEST(ExplainUnknownTrack, NamesWhatIsMissingAndQuotesTheFirstLine) {
  const std::string page = "<!DOCTYPE html>\n<html>";
  EXPECT_THAT(InWords(*ExplainUnknownTrack(BytesOf(page), "a.GPX")), HasSubstr("<gpx>"));
  EXPECT_THAT(InWords(*ExplainUnknownTrack(BytesOf(page), "a.GPX")), HasSubstr("\"<!DOCTYPE html>\""));
  EXPECT_THAT(InWords(*ExplainUnknownTrack(BytesOf("PK\x03\x04"), "a.kmz")), HasSubstr("Unzip"));
  EXPECT_THAT(InWords(*ExplainUnknownTrack(BytesOf(std::string("\0\1", 2)), "a.ass")), HasSubstr("no text"));
  EXPECT_FALSE(ExplainUnknownTrack(BytesOf(page), "a.txt"));
  const std::string area =
      R"({"type":"GeometryCollection","geometries":[{"type":"Polygon","coordinates":[]}]})";
  EXPECT_THAT(InWords(*ExplainUnknownTrack(BytesOf(area), "area.geojson")), HasSubstr("--boundary"));
  EXPECT_FALSE(RecogniseLog(BytesOf(page), "a.gpx")->has_value());
}

}  // namespace
}  // namespace skyquilt::flight
