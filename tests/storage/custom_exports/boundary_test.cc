#include "storage/exports/custom/boundary.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <utility>

#include "core/geo/web_mercator.h"
#include "tests/support/value_of.h"

namespace skyquilt::storage {
namespace {

std::string Square(double west, double south, double east, double north) {
  const auto at = [](double lon, double lat) {
    return "[" + std::to_string(lon) + "," + std::to_string(lat) + "]";
  };
  return "[" + at(west, south) + "," + at(east, south) + "," + at(east, north) + "," + at(west, north) + "," +
         at(west, south) + "]";
}

std::string Polygon(const std::string& rings) {
  return R"({"type":"Polygon","coordinates":[)" + rings + "]}";
}

TEST(ParseBoundary, TakesEveryFormOfPolygons) {
  const std::string square = Square(7.0, 46.0, 8.0, 47.0);
  for (
      const std::string& text :
      {Polygon(square), R"({"type":"MultiPolygon","coordinates":[[)" + square + "]]}",
       R"({"type":"Feature","properties":{},"geometry":)" + Polygon(square) + "}",
       R"({"type":"FeatureCollection","features":[{"type":"Feature","geometry":)" + Polygon(square) + "}]}",
       R"({"type":"GeometryCollection","geometries":[)" + Polygon(square) + "]}",
       R"({"type":"FeatureCollection","features":[{"type":"Feature","geometry":null},)"
       R"({"type":"Feature","geometry":{"type":"Point","coordinates":[7.5,46.5]}},)"
       R"({"type":"Feature","geometry":{"type":"LineString","coordinates":[[9,46],[9,47]]}},)"
       R"({"type":"Feature","geometry":)" +
           Polygon(square) + "}]}",
       R"({"type":"Polygon","crs":{"type":"name","properties":{"name":"urn:ogc:def:crs:OGC:1.3:CRS84"}},"coordinates":[)" +
           square + "]}"}) {
    const auto boundary = ParseBoundary(text);
    ASSERT_TRUE(boundary.ok()) << text << boundary.error().message;
    EXPECT_EQ(boundary->Bounds(), (geo::LatLonBounds{7.0, 46.0, 8.0, 47.0}));
  }
}

TEST(ParseBoundary, SaysWhatIsWrongAndWhatToGive) {
  const std::pair<std::string, const char*> bad[] = {
      {"", "not JSON"},
      {"[1,2]", "not JSON"},
      {R"({"type":"Point","coordinates":[7,46]})", "a Point"},
      {R"({"coordinates":[[[7,46]]]})", "no \"type\""},
      {R"({"type":"FeatureCollection","features":[]})", "no polygon"},
      {R"({"type":"FeatureCollection","features":[3]})", "none"},
      {R"({"type":"FeatureCollection","features":[{"type":"Point","coordinates":[7,46]}]})", "no polygon"},
      {R"({"type":"FeatureCollection","features":[{"type":"Circle","coordinates":[7,46]}]})", "a Circle"},
      {R"({"type":"Feature","geometry":{"type":"LineString","coordinates":[[7,46],[8,47]]}})",
       "a LineString"},
      {R"({"type":"Feature","geometry":null})", "no polygon"},
      {R"({"type":"Polygon","coordinates":[]})", "no outline"},
      {R"({"type":"Polygon","coordinates":[[[7,46],[8,46],[7,46]]]})", "fewer than four"},
      {R"({"type":"Polygon","coordinates":[[[7,46],[8,46],["a",2],[7,46]]]})", "not [longitude, latitude]"},
      {R"({"type":"Polygon","coordinates":[[[2600000,1200000],[8,46],[7,47],[7,46]]]})",
       "no place in degrees"},
      {R"({"type":"Polygon","crs":{"properties":{"name":"EPSG:2056"}},"coordinates":[]})", "EPSG:2056"},
      {R"({"type":"Polygon","coordinates":)" + std::string(200, '[') + std::string(200, ']') + "}",
       "too deeply"}};
  for (const auto& [text, word] : bad) {
    const auto boundary = ParseBoundary(text);
    ASSERT_FALSE(boundary.ok()) << text;
    EXPECT_NE(boundary.error().message.find(word), std::string::npos) << boundary.error().message;
    EXPECT_NE(boundary.error().message.find("Polygon"), std::string::npos) << boundary.error().message;
  }
}

TEST(ParseArea, RefusesRingsThatCrossThemselves) {
  const std::string square = Square(7.0, 46.0, 8.0, 47.0);
  const std::pair<std::string, const char*> crossing[] = {
      {"[[7,46],[8,47],[8,46],[7,47],[7,46]]", "a bow tie"},
      {square + ",[[7.2,46.2],[7.8,46.8],[7.8,46.2],[7.2,46.8],[7.2,46.2]]", "a hole"},
      {"[[7,46],[9,46],[9,47],[8,45],[7,47],[7,46]]", "over one edge and back"},
      {"[[179,-17],[-179,-16],[-179,-17],[179,-16],[179,-17]]", "across the antimeridian"}};
  for (const auto& [rings, what] : crossing) {
    EXPECT_TRUE(ParseBoundary(Polygon(rings)).ok()) << what;
    const auto area = ParseArea(Polygon(rings));
    ASSERT_FALSE(area.ok()) << what;
    EXPECT_NE(area.error().message.find("crosses itself: put its corners in the order"), std::string::npos)
        << area.error().message;
  }
  const std::pair<std::string, const char*> whole[] = {
      {square + "," + Square(7.0, 46.0, 7.5, 46.5), "a hole along the edge"},
      {"[[7,46],[8,46],[8,46],[8,47],[7,47],[7,46]]", "a corner set twice"},
      {"[[7,46],[8,46],[8,47],[7.5,46],[7,47],[7,46]]", "a corner on an edge"},
      {"[[7,46],[8,46],[7.5,46.5],[8,47],[7,47],[7.5,46.5],[7,46]]", "a corner on another"},
      {"[[7,46],[7.2,46.2],[7.8,46.2],[7.5,46.8],[7.2,46.2],[7,46],[7,47],[8,47],[8,46],[7,46]]", "a slit"},
      {"[[179,-17],[-179,-17],[-179.5,-16.5],[-179,-16],[179,-16],[179,-17]]", "across the antimeridian"},
      {Square(-180.0, -90.0, 180.0, 90.0), "the world"}};
  for (const auto& [rings, what] : whole) EXPECT_TRUE(ParseArea(Polygon(rings)).ok()) << what;
}

TEST(BoundaryOnZoom, CountsPixelsByTheirMiddles) {
  // Tile 1/0/0 is the north-west quarter of the world; the box covers the western half of its southern half.
  const double lat = geo::LatLonFromMerc({0.0, geo::kMercHalfWidthM / 2}).lat_deg;
  const auto boundary = test::ValueOf(ParseBoundary(Polygon(Square(-180.0, 0.0, -90.0, lat))));
  const BoundaryOnZoom on_zoom(boundary, 1, 256);
  std::vector<std::uint8_t> inside;
  EXPECT_EQ(on_zoom.Mask(*geo::TileId::Make(1, 0, 0), inside), Cover::kPart);
  EXPECT_EQ(std::count(inside.begin(), inside.end(), 1), 128 * 128);
  EXPECT_EQ(inside[127 * 256], 0);
  EXPECT_EQ(inside[128 * 256], 1);
  EXPECT_EQ(inside[128 * 256 + 127], 1);
  EXPECT_EQ(inside[128 * 256 + 128], 0);
  EXPECT_EQ(on_zoom.Mask(*geo::TileId::Make(1, 1, 0), inside), Cover::kNone);
  const BoundaryOnZoom finer(boundary, 2, 256);
  EXPECT_EQ(finer.Mask(*geo::TileId::Make(2, 0, 1), inside), Cover::kAll);
}

TEST(BoundaryOnZoom, KeepsHolesEmptyAndTakesPolygonsTogether) {
  const auto with_hole =
      ParseBoundary(Polygon(Square(-170.0, 10.0, -10.0, 80.0) + "," + Square(-120.0, 30.0, -60.0, 60.0)));
  ASSERT_TRUE(with_hole.ok());
  std::vector<std::uint8_t> inside;
  BoundaryOnZoom(*with_hole, 1, 256).Mask(*geo::TileId::Make(1, 0, 0), inside);
  const auto pixel = [&](double lon, double lat) {
    const Eigen::Vector2d merc = geo::MercFromLatLon({lat, lon});
    const double size_m = geo::kMercHalfWidthM / 256;
    const auto x = static_cast<std::size_t>((merc.x() + geo::kMercHalfWidthM) / size_m),
               y = static_cast<std::size_t>((geo::kMercHalfWidthM - merc.y()) / size_m);
    return inside[y * 256 + x];
  };
  EXPECT_EQ(pixel(-90.0, 45.0), 0);
  EXPECT_EQ(pixel(-140.0, 45.0), 1);
  // Overlapping polygons of a collection do not cancel each other.
  const std::string square = Polygon(Square(-170.0, 10.0, -10.0, 80.0));
  const auto twice =
      ParseBoundary(R"({"type":"FeatureCollection","features":[)" + square + "," + square + "]}");
  ASSERT_TRUE(twice.ok());
  BoundaryOnZoom(*twice, 1, 256).Mask(*geo::TileId::Make(1, 0, 0), inside);
  EXPECT_EQ(pixel(-90.0, 45.0), 1);
}

TEST(BoundaryOnZoom, LiesOnBothSidesOfTheAntimeridianWithItsHoles) {
  const auto boundary =
      test::ValueOf(ParseBoundary(Polygon("[[170,-40],[-170,-40],[-170,40],[170,40],[170,-40]],"
                                          "[[-175,-20],[175,-20],[175,20],[-175,20],[-175,-20]]")));
  EXPECT_EQ(boundary.Bounds(), (geo::LatLonBounds{170.0, -40.0, 190.0, 40.0}));
  const auto from_east = test::ValueOf(ParseBoundary(Polygon("[[-170,-40],[-170,40],[170,40],[-170,-40]]")));
  EXPECT_EQ(from_east.Bounds(), boundary.Bounds());
  constexpr int kZoom = 4, kSidePx = 64;
  const BoundaryOnZoom on_zoom(boundary, kZoom, kSidePx);
  std::vector<std::uint8_t> inside;
  const auto holds = [&](double lon, double lat) {
    const Eigen::Vector2d merc = geo::MercFromLatLon({lat, lon});
    const geo::TileId tile = geo::TileId::AtMerc(kZoom, merc);
    EXPECT_EQ(on_zoom.Mask(tile, inside), on_zoom.CoverOf(tile)) << lon << " " << lat;
    const geo::Bounds2 bounds = tile.BoundsInMerc();
    const double pixel_m = bounds.Width() / kSidePx;
    const auto x = static_cast<std::size_t>((merc.x() - bounds.min.x()) / pixel_m),
               y = static_cast<std::size_t>((bounds.max.y() - merc.y()) / pixel_m);
    return inside[y * kSidePx + x] != 0;
  };
  for (const double lon : {172.0, -172.0}) EXPECT_TRUE(holds(lon, 0.0) && holds(lon, 30.0)) << lon;
  for (const double lon : {178.0, -178.0}) EXPECT_TRUE(!holds(lon, 0.0) && holds(lon, -30.0)) << lon;
  for (const double lon : {168.0, -168.0, 0.0, 90.0}) EXPECT_FALSE(holds(lon, 0.0)) << lon;
}

TEST(BoundaryOnZoom, SaysOfATileWhatItsPixelsSay) {
  // A comb of many teeth with a hole beside it, over tiles of several sizes.
  std::string comb = "[[7.0,46.0]";
  for (int i = 0; i < 40; ++i) {
    comb += ",[" + std::to_string(7.0 + 0.02 * i) + "," + std::to_string(i % 2 == 0 ? 46.2 : 46.9) + "]";
  }
  comb += ",[7.8,46.0],[7.0,46.0]]";
  const auto boundary =
      ParseBoundary(R"({"type":"MultiPolygon","coordinates":[[)" + comb + "],[" +
                    Square(8.0, 46.0, 9.0, 47.0) + "," + Square(8.2, 46.2, 8.8, 46.8) + "]]}");
  ASSERT_TRUE(boundary.ok()) << boundary.error().message;
  int covers[3] = {0, 0, 0};
  for (const int zoom : {7, 9, 11}) {
    const BoundaryOnZoom on_zoom(*boundary, zoom, 64);
    const geo::TileId first = geo::TileId::AtMerc(zoom, geo::MercFromLatLon({47.1, 6.9}));
    const geo::TileId last = geo::TileId::AtMerc(zoom, geo::MercFromLatLon({45.9, 9.1}));
    std::vector<std::uint8_t> inside;
    for (std::uint32_t y = first.y(); y <= last.y(); ++y) {
      for (std::uint32_t x = first.x(); x <= last.x(); ++x) {
        const geo::TileId tile = *geo::TileId::Make(zoom, x, y);
        const Cover cover = on_zoom.Mask(tile, inside);
        EXPECT_EQ(static_cast<int>(on_zoom.CoverOf(tile)), static_cast<int>(cover))
            << zoom << " " << x << " " << y;
        ++covers[static_cast<int>(cover)];
      }
    }
  }
  for (const int count : covers) EXPECT_GT(count, 3);
}

TEST(ParseBoundaryFile, ReadsPolygonsOfKml) {
  const std::string kml =
      R"(<?xml version="1.0"?><kml xmlns="http://www.opengis.net/kml/2.2"><Document><Folder>)"
      R"(<Placemark><Point><coordinates>1,2</coordinates></Point></Placemark>)"
      R"(<Placemark><MultiGeometry><Polygon><innerBoundaryIs><LinearRing><coordinates>)"
      "7.2,46.2 7.8,46.2 7.8,46.8 7.2,46.8 7.2,46.2</coordinates></LinearRing></innerBoundaryIs>"
      "<outerBoundaryIs><LinearRing><coordinates>\n 7,46,400\n 8,46,400 8,47,0\t7,47 7,46 "
      "</coordinates></LinearRing></outerBoundaryIs></Polygon></MultiGeometry></Placemark>"
      "</Folder></Document></kml>";
  for (const std::string& text : {kml, "\xef\xbb\xbf \n" + kml}) {
    const auto boundary = test::ValueOf(ParseBoundaryFile(text));
    ASSERT_EQ(boundary.polygons.size(), 1U);
    ASSERT_EQ(boundary.polygons[0].size(), 2U);
    EXPECT_EQ(boundary.Bounds(), (geo::LatLonBounds{7.0, 46.0, 8.0, 47.0}));
    EXPECT_DOUBLE_EQ(boundary.polygons[0][1][0].lon_deg, 7.2);
  }
  EXPECT_TRUE(ParseBoundaryFile(" " + Polygon(Square(7.0, 46.0, 8.0, 47.0))).ok());
  const auto polygon = [](const std::string& coordinates) {
    return "<kml><Polygon><outerBoundaryIs><LinearRing><coordinates>" + coordinates +
           "</coordinates></LinearRing></outerBoundaryIs></Polygon></kml>";
  };
  const std::pair<std::string, const char*> bad[] = {
      {"<kml>", "neither GeoJSON nor KML"},
      {"<gpx/>", "neither GeoJSON nor KML"},
      {std::string("PK\x03\x04\x14", 5), "Unzip it"},
      {"<kml></kml>", "no polygon"},
      {"<kml><Polygon></Polygon></kml>", "no outline"},
      {polygon("7,46 8,46 7,46"), "fewer than four"},
      {polygon(""), "fewer than four"},
      {polygon("7,46 8,46 8;47 7,46"), "longitude,latitude"},
      {polygon("7,46 8,46 8, 7,46"), "fewer than four"},
      {polygon("2600000,1200000 8,46 8,47 7,46"), "no place in degrees"},
      {polygon("nan,46 8,46 8,47 7,46"), "no place in degrees"}};
  for (const auto& [text, word] : bad) {
    const auto boundary = ParseBoundaryFile(text);
    ASSERT_FALSE(boundary.ok()) << text;
    EXPECT_NE(boundary.error().message.find(word), std::string::npos) << text << boundary.error().message;
  }
}

}  // namespace
}  // namespace skyquilt::storage
