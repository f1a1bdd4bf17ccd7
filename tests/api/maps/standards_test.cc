// What the documents of the map standards say of maps with usual and with larger tiles.
#include <array>
#include <cmath>

#include "api/tiles/recode_tile.h"
#include "tests/api/sample_service.h"

namespace skyquilt::api {
namespace {

using nlohmann::json;

int CountOf(const std::string& text, const std::string& part) {
  int count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

class StandardsTest : public testing::TestWithParam<int> {
 protected:
  StandardsTest() : depth_(static_cast<int>(std::log2(GetParam() / 256))), flight_(sample_.NewFlight()) {
    const std::string png = TransparentPng(GetParam());
    sample_.Publish(flight_, {{2, 1, 2, png}, {3, 2, 5, png}}, GetParam());
  }
  std::string Body(const std::string& path) { return sample_.Body(path); }

  int depth_;
  SampleService sample_;
  std::string flight_;
};

TEST_P(StandardsTest, AddressesWithoutARequestAreCapabilities) {
  for (const char* query : {"", "?request=", "?REQUEST=nonsense", "?service=wms&request=getcapabilities",
                            "?SERVICE=WMTS&REQUEST=GetCapabilities"}) {
    EXPECT_NE(Body("/wmts/" + flight_ + query).find("<Capabilities "), std::string::npos) << query;
    EXPECT_NE(Body("/wms/" + flight_ + query).find("<WMS_Capabilities "), std::string::npos) << query;
  }
  EXPECT_EQ(sample_.Get("/wmts/" + flight_ + "?request=GetMap").status, 501);
  EXPECT_EQ(sample_.Get("/wmts/" + flight_ + "?request=GetTile").status, 400);
  EXPECT_EQ(sample_.Get("/wms/" + flight_ + "?request=GetTile").status, 400);
  EXPECT_EQ(sample_.Get("/wms/" + flight_ + "?request=GetMap").status, 400);
}

TEST_P(StandardsTest, WmtsNamesTheUsualSizeFirst) {
  const std::string text = Body("/wmts/" + flight_);
  EXPECT_EQ(CountOf(text, "<TileMatrixSetLink>"), (depth_ > 0 ? 2 : 1) + 2);  // and degrees, and UTM
  const std::size_t usual = text.find("<TileMatrixSet>WebMercatorQuad</TileMatrixSet>");
  ASSERT_NE(usual, std::string::npos);
  EXPECT_LT(usual,
            text.find("<TileMatrixSet>WebMercatorQuad" + std::to_string(GetParam()) + "</TileMatrixSet>"));
  EXPECT_NE(text.find("<TileMatrixLimits><TileMatrix>" + std::to_string(3 + depth_) + "<"),
            std::string::npos);
}

TEST_P(StandardsTest, WmtsHasTilesAsTheyAreStored) {
  const std::string set = "WebMercatorQuad" + (depth_ > 0 ? std::to_string(GetParam()) : "");
  const std::string text = Body("/wmts/" + flight_);
  EXPECT_LT(text.find("<Format>image/png</Format>"), text.find("<Format>image/vnd.jpeg-png</Format>"));
  EXPECT_NE(text.find("format=\"image/vnd.jpeg-png\" resourceType=\"tile\""), std::string::npos);
  const std::string tile = "/wmts/" + flight_ +
                           "?REQUEST=GetTile&LAYER=map&STYLE=default&TILEMATRIX=3&TILEROW=5&TILECOL=2"
                           "&TILEMATRIXSET=" +
                           set + "&FORMAT=image/";
  const Response stored = sample_.Get(tile + "vnd.jpeg-png");
  EXPECT_EQ(stored.status, 200) << stored.body;
  EXPECT_EQ(stored.body, sample_.Get("/tiles/" + flight_ + "/3/2/5").body);
  EXPECT_EQ(sample_.Get(tile + "vnd.jpeg").status, 400);
}

TEST_P(StandardsTest, TheLayerOfQgisIsAsLargeAsTheMap) {
  const std::string text = Body("/connect/" + flight_ + "/qgis.qlr?token=abc");
  EXPECT_EQ(text.find("type=xyz"), std::string::npos);  // which QGIS takes to be as large as the world
  EXPECT_NE(
      text.find("tileMatrixSet=WebMercatorQuad" + (depth_ > 0 ? std::to_string(GetParam()) : "") + "&amp;"),
      std::string::npos);
  EXPECT_NE(text.find("%26token%3Dabc"), std::string::npos);
  const auto [west, south, east, north] =
      json::parse(Body("/tiles/" + flight_ + ".json"))["bounds"].get<std::array<double, 4>>();
  const double metres_a_degree = 20037508.342789244 / 180.0;
  const auto number = [&](const std::string& name) {
    const std::size_t at = text.find("<" + name + ">");
    return at == std::string::npos ? NAN : std::stod(text.substr(at + name.size() + 2));
  };
  EXPECT_NEAR(number("xmin"), west * metres_a_degree, 0.01);
  EXPECT_NEAR(number("xmax"), east * metres_a_degree, 0.01);
  EXPECT_LT(number("ymin"), number("ymax"));
}

TEST_P(StandardsTest, TmsCountsFromTheWorld) {
  const std::string text = Body("/tms/1.0.0/" + flight_ + "?token=abc");
  EXPECT_EQ(CountOf(text, "<TileSet "), 4 + depth_);
  EXPECT_NE(text.find("order=\"0\""), std::string::npos);
  EXPECT_NE(text.find("<TileFormat width=\"256\""), std::string::npos);
  EXPECT_NE(text.find("minx=\"-20037508.342789244\""), std::string::npos);
  EXPECT_NE(text.find("extension=\"png?token=abc\""), std::string::npos);
  const std::string all = "href=\"http://127.0.0.1:1/tms/1.0.0?token=abc\"";
  EXPECT_NE(Body("/tms?token=abc").find(all), std::string::npos);
  EXPECT_NE(text.find("tilemapservice=\"http://127.0.0.1:1/tms/1.0.0?token=abc\""), std::string::npos);
  EXPECT_EQ(CountOf(Body("/tms/1.0.0"), "<TileMap "), depth_ > 0 ? 2 : 1);
  EXPECT_EQ(sample_.Get("/tms/1.0.0/" + flight_ + "/0/0/0.png").status, 200);
  EXPECT_EQ(sample_.Get("/tms/1.0.0/" + flight_ + "/20/0/0.png").status, 404);
  EXPECT_EQ(sample_.Get("/tms/1.0.0/" + flight_ + "/128").status, 404);
}

TEST_P(StandardsTest, ArcgisFindsServiceLayerAndLevels) {
  const json services = json::parse(Body("/arcgis/rest/services?f=pjson"))["services"];
  ASSERT_EQ(services.size(), 1u);
  EXPECT_EQ(services[0]["name"], flight_);
  const std::string at = "/arcgis/rest/services/" + flight_ + "/MapServer";
  const json map = json::parse(Body(at + "?f=json"));
  const json& levels = map["tileInfo"]["lods"];
  ASSERT_EQ(levels.size(), static_cast<std::size_t>(4 + depth_));
  EXPECT_EQ(levels[0]["level"], 0);
  EXPECT_NEAR(levels[0]["resolution"].get<double>() * map["tileInfo"]["cols"].get<int>(), 40075016.68557849,
              1e-6);
  EXPECT_EQ(map["maxScale"], levels.back()["scale"]);
  EXPECT_EQ(map["capabilities"], "Map,TilesOnly");  // nobody is to ask it for "export"
  const json layer = json::parse(Body(at + "/0"));
  EXPECT_EQ(layer["extent"], map["fullExtent"]);
  EXPECT_EQ(json::parse(Body(at + "/layers?f=json")),
            (json{{"layers", json::array({layer})}, {"tables", json::array()}}));
  const json legend = json::parse(Body(at + "/legend?f=pjson"));
  ASSERT_EQ(legend["layers"].size(), 1u);
  EXPECT_EQ(legend["layers"][0]["layerId"], map["layers"][0]["id"]);
  EXPECT_EQ(legend["layers"][0]["legend"], json::array());
  for (const char* rest : {"/layers", "/legend"}) EXPECT_EQ(sample_.Get(at + rest + "?f=kmz").status, 400);
  const Response unknown = sample_.Get(at + "/identify?geometry=1,2&f=json");
  EXPECT_EQ(unknown.status, 404);
  EXPECT_NE(unknown.body.find("has no \\\"identify\\\""), std::string::npos) << unknown.body;
  EXPECT_EQ(sample_.Get(at + "?f=kmz").status, 400);
  EXPECT_EQ(sample_.Get("/arcgis/rest/services/" + sample_.NewFlight() + "/MapServer/0").status, 404);
}

INSTANTIATE_TEST_SUITE_P(OfAllSizes, StandardsTest, testing::Values(256, 512, 1024));

// One window from its west to its east, beyond 180 degrees; the tiles there are those of the other end.
TEST(ConnectFiles, OfAMapAcrossTheAntimeridianCoverBothSides) {
  SampleService sample;
  const std::string flight = sample.NewFlight(), png = TransparentPng(256);
  sample.PublishAt({179.75, 0.1, 180.25, 0.3}, flight, {{10, 1023, 512, png}, {10, 0, 512, png}});
  const std::string gdal = sample.Get("/connect/" + flight + "/gdal.xml").body;
  EXPECT_NE(gdal.find("<SizeX>512</SizeX>"), std::string::npos) << gdal;
  EXPECT_NE(gdal.find("<TileX>1023</TileX>"), std::string::npos) << gdal;
  const std::string tiles = "/tiles/" + flight + "/10/";
  EXPECT_EQ(sample.Get(tiles + "1024/511").status, 200);
  EXPECT_EQ(sample.Get(tiles + "1024/511").headers.Find("ETag"),
            sample.Get(tiles + "0/511").headers.Find("ETag"));
  EXPECT_EQ(sample.Get(tiles + "1030/511").status, 404);
  EXPECT_EQ(sample.Get(tiles + "2048/511").status, 400);
  const std::string josm = sample.Get("/connect/" + flight + "/josm.xml").body;
  EXPECT_NE(josm.find("min-lon=\"179.7500000\""), std::string::npos) << josm;
  EXPECT_NE(josm.find("max-lon=\"-179.7500000\""), std::string::npos) << josm;
}

}  // namespace
}  // namespace skyquilt::api
