// WMTS, WMS and the list of TileJSON of all maps at one address, and what lies under a pixel of them.
#include "api/tiles/recode_tile.h"
#include "api/views/feature_info.h"
#include "api/wms/wms_request.h"
#include "tests/api/sample_service.h"

namespace skyquilt::api {
namespace {

using nlohmann::json;

std::string PlainTile(std::uint8_t red, std::uint8_t green, std::uint8_t blue, int side_px = 256) {
  image::RgbaImage tile = image::RgbaImage::Transparent(side_px, side_px);
  for (std::size_t i = 0; i < tile.rgba.size(); i += 4) {
    tile.rgba[i] = red;
    tile.rgba[i + 1] = green;
    tile.rgba[i + 2] = blue;
    tile.rgba[i + 3] = 255;
  }
  return EncodeTile(std::move(tile), image::PictureFormat::kPng);
}

class AllMapsTest : public testing::Test {
 protected:
  AllMapsTest() {
    sample_.Publish(red_, {{2, 1, 2, PlainTile(200, 10, 20)}});
    sample_.Publish(large_, {{2, 1, 2, PlainTile(10, 200, 20, 512)}}, 512);
  }
  std::string Body(const std::string& path, Headers headers = {}) {
    return sample_.Body(path, std::move(headers));
  }
  std::array<int, 4> PixelOf(const std::string& path) {
    const image::RgbaImage picture = sample_.Picture(path);
    const std::uint8_t* pixel = picture.Pixel(picture.width_px / 2, picture.height_px / 2);
    return {pixel[0], pixel[1], pixel[2], pixel[3]};
  }

  SampleService sample_;
  std::string red_ = sample_.NewFlight();
  std::string large_ = sample_.NewFlight();
  std::string without_ = sample_.NewFlight();
};

// Tile 2/1/1 is west of Greenwich and north of the equator.
constexpr const char* kBox =
    "&CRS=CRS:84&BBOX=-80,10,-10,60&WIDTH=100&HEIGHT=90&FORMAT=image/png&TRANSPARENT=TRUE";

TEST_F(AllMapsTest, WmtsHasALayerForEachMap) {
  for (const char* path :
       {"/wmts", "/wmts?service=WMTS&request=GetCapabilities", "/wmts/1.0.0/WMTSCapabilities.xml"}) {
    const std::string text = Body(path);
    for (const std::string& flight : {red_, large_}) {
      EXPECT_NE(text.find("<ows:Identifier>" + flight + "</ows:Identifier>"), std::string::npos) << path;
      EXPECT_NE(text.find("/wmts/" + flight + "/map/{Style}/"), std::string::npos) << path;
    }
    EXPECT_EQ(text.find(without_), std::string::npos);
    EXPECT_NE(text.find("<ows:Identifier>WebMercatorQuad512</ows:Identifier>"), std::string::npos);
  }
  const std::string tile =
      "&TileMatrixSet=WebMercatorQuad&TileMatrix=2&TileRow=1&TileCol=1&Format=image/png&Style=default";
  EXPECT_EQ(PixelOf("/wmts?Request=GetTile&Layer=" + red_ + tile), (std::array{200, 10, 20, 255}));
  const std::string deeper =
      "&TileMatrixSet=WebMercatorQuad&TileMatrix=3&TileRow=2&TileCol=2&Format=image/png";
  EXPECT_EQ(PixelOf("/wmts?Request=GetTile&Layer=" + large_ + deeper), (std::array{10, 200, 20, 255}));
  for (const std::string& layer : {std::string("map"), std::string("nothing"), std::string("..")})
    EXPECT_EQ(sample_.Get("/wmts?Request=GetTile&Layer=" + layer + tile).status, 400) << layer;
  EXPECT_EQ(sample_.Get("/wmts?cursor=x").status, 400);
}

// One set has the zooms of all maps, and QGIS asks for the one nearest to its view, whatever the layer's
// limits.
TEST_F(AllMapsTest, WmtsDrawsLayersAtZoomsOfOthers) {
  const std::array red = {200, 10, 20, 255}, green = {10, 200, 20, 255};
  const std::string ask = "?Request=GetTile&Format=image/png&Style=";
  const std::string of_red = "/wmts" + ask + "&Layer=" + red_ + "&TileMatrixSet=";
  EXPECT_EQ(PixelOf(of_red + "WebMercatorQuad&TileMatrix=1&TileRow=0&TileCol=0"), red);
  EXPECT_EQ(PixelOf(of_red + "WebMercatorQuad&TileMatrix=5&TileRow=9&TileCol=9"), red);
  EXPECT_EQ(PixelOf(of_red + "WorldCRS84Quad&TileMatrix=3&TileRow=2&TileCol=6"), red);
  const std::string of_large = "/wmts" + ask + "&Layer=" + large_ + "&TileMatrixSet=";
  EXPECT_EQ(PixelOf(of_large + "WebMercatorQuad&TileMatrix=6&TileRow=18&TileCol=18"), green);
  EXPECT_EQ(PixelOf(of_large + "WebMercatorQuad512&TileMatrix=4&TileRow=5&TileCol=5"), green);
  EXPECT_EQ(PixelOf("/wmts?Request=GetTile&Format=image/png&Style=vari&Layer=" + red_ +
                    "&TileMatrixSet=WebMercatorQuad&TileMatrix=1&TileRow=0&TileCol=0")[3],
            255);
  // A map's own service has its own zooms alone.
  const std::string own = "/wmts/" + red_ + ask + "&Layer=map&TileMatrixSet=WebMercatorQuad";
  EXPECT_EQ(sample_.Get(own + "&TileMatrix=5&TileRow=9&TileCol=9").status, 404);
}

TEST_F(AllMapsTest, FlightsWithoutMapsTakeNoPlaceInLists) {
  for (int i = 0; i < 200; ++i) sample_.NewFlight();
  for (const char* path : {"/tms/1.0.0", "/arcgis/rest/services"})
    EXPECT_NE(Body(path).find(red_), std::string::npos) << path;
}

TEST_F(AllMapsTest, WmsLaysLayersOverEachOther) {
  for (const char* version : {"1.3.0", "1.1.1"}) {
    const std::string text = Body(std::string("/wms?REQUEST=GetCapabilities&VERSION=") + version);
    for (const std::string& flight : {red_, large_})
      EXPECT_NE(text.find("<Name>" + flight + "</Name>"), std::string::npos);
  }
  const std::string get = std::string("/wms?REQUEST=GetMap&VERSION=1.3.0&STYLES=") + kBox + "&LAYERS=";
  EXPECT_EQ(PixelOf(get + red_), (std::array{200, 10, 20, 255}));
  EXPECT_EQ(PixelOf(get + red_ + "," + large_), (std::array{10, 200, 20, 255}));
  EXPECT_EQ(PixelOf(get + large_ + "," + red_), (std::array{200, 10, 20, 255}));
  std::string many = red_;
  for (int i = 0; i < 16; ++i) many += "," + red_;
  for (const std::string& layers : {std::string(), std::string("map"), red_ + ",", many}) {
    const Response response = sample_.Get(get + layers);
    EXPECT_EQ(response.status, 400) << layers;
    if (layers != many) {
      EXPECT_NE(response.body.find("LayerNotDefined"), std::string::npos) << layers;
    }
  }
  // Without a version, what names the system tells it.
  const std::string unsaid = "/wms?REQUEST=GetMap&BBOX=-80,10,-10,60&WIDTH=100&HEIGHT=90&FORMAT=image/png";
  EXPECT_EQ(PixelOf(unsaid + "&SRS=EPSG:4326&LAYERS=" + red_), (std::array{200, 10, 20, 255}));
  for (const char* systems : {"&CRS=CRS:84", "&SRS=EPSG:4326&CRS=CRS:84", "&CRS=CRS:84&SRS=EPSG:1"})
    EXPECT_EQ(PixelOf(unsaid + systems + "&LAYERS=" + red_), (std::array{200, 10, 20, 255})) << systems;
  const std::string wrong = "/wms?REQUEST=GetMap&VERSION=1.3.0&STYLES=&FORMAT=image/png&LAYERS=" + red_;
  for (const char* window :
       {"&CRS=EPSG:999999&BBOX=0,0,1,1&WIDTH=9&HEIGHT=9", "&CRS=CRS:84&BBOX=0,0,1,1&WIDTH=1e9&HEIGHT=1",
        "&CRS=CRS:84&BBOX=1,0,0,1&WIDTH=9&HEIGHT=9", "&CRS=CRS:84&BBOX=nan,0,0,1&WIDTH=9&HEIGHT=9",
        "&CRS=CRS:84&BBOX=0,0,1,1&WIDTH=-1&HEIGHT=9"}) {
    EXPECT_EQ(sample_.Get(wrong + window).status, 400) << window;
  }
}

// QGIS cuts a print into pieces of the size that capabilities name.
TEST_F(AllMapsTest, WmsTakesAPictureOfTheSizeThatItNames) {
  const std::string text = Body("/wms?REQUEST=GetCapabilities&VERSION=1.3.0");
  Request request;
  request.query = {{"LAYERS", red_}, {"CRS", "CRS:84"}, {"BBOX", "0,0,1,1"}, {"FORMAT", "image/png"}};
  for (const auto& [element, parameter] : {std::pair{"<MaxWidth>", "WIDTH"}, {"<MaxHeight>", "HEIGHT"}}) {
    const std::size_t at = text.find(element);
    ASSERT_NE(at, std::string::npos) << element;
    const std::size_t first = at + std::string_view(element).size();
    request.query.emplace_back(parameter, text.substr(first, text.find('<', first) - first));
  }
  EXPECT_TRUE(ParseGetMap(request));
}

// Boxes of such a map go on beyond 180 degrees, in its capabilities and in what programs ask for.
TEST_F(AllMapsTest, PicturesOfAMapAcrossTheAntimeridianShowBothSides) {
  const std::string flight = sample_.NewFlight();
  sample_.PublishAt({179.75, 0.1, 180.25, 0.3}, flight,
                    {{10, 1023, 512, PlainTile(200, 10, 20)}, {10, 0, 512, PlainTile(10, 200, 20)}});
  const std::string wms = "/wms/" + flight + "?REQUEST=GetMap&VERSION=1.3.0&LAYERS=map&STYLES=" +
                          "&FORMAT=image/png&TRANSPARENT=TRUE&WIDTH=40&HEIGHT=16";
  const std::string maps = "/ogc/collections/" + flight + "/map?width=40&height=16&f=png";
  for (const std::string& path :
       {wms + "&CRS=CRS:84&BBOX=179.75,0.1,180.25,0.3", wms + "&CRS=CRS:84&BBOX=-180.25,0.1,-179.75,0.3",
        wms + "&CRS=EPSG:4326&BBOX=0.1,179.75,0.3,180.25",
        wms + "&CRS=EPSG:3857&BBOX=20009678,11132,20065338,33396",
        maps + "&bbox=179.75,0.1,-179.75,0.3&crs=[OGC:CRS84]"}) {
    const image::RgbaImage picture = sample_.Picture(path);
    const std::uint8_t *west = picture.Pixel(5, 8), *east = picture.Pixel(34, 8);
    EXPECT_EQ((std::array<int, 4>{west[0], west[1], west[2], west[3]}), (std::array{200, 10, 20, 255}))
        << path;
    EXPECT_EQ((std::array<int, 4>{east[0], east[1], east[2], east[3]}), (std::array{10, 200, 20, 255}))
        << path;
  }
}

// What is asked beyond 180 degrees is told of the place where its tiles and photos are.
TEST_F(AllMapsTest, FeatureInfoOfAMapAcrossTheAntimeridianIsOfAPlaceOnEarth) {
  const std::string flight = sample_.NewFlight();
  sample_.PublishAt({179.75, 0.1, 180.25, 0.3}, flight,
                    {{10, 1023, 512, PlainTile(200, 10, 20)}, {10, 0, 512, PlainTile(10, 200, 20)}});
  const std::string ask = "/wms/" + flight +
                          "?REQUEST=GetFeatureInfo&VERSION=1.3.0&QUERY_LAYERS=map&CRS=CRS:84"
                          "&WIDTH=40&HEIGHT=16&J=8&BBOX=179.75,0.1,180.25,0.3&I=";
  const json west = json::parse(Body(ask + "5"))["features"][0];
  EXPECT_EQ(west["properties"]["red"], 200);
  EXPECT_NEAR(west["geometry"]["coordinates"][0].get<double>(), 179.81875, 1e-6);
  const json east = json::parse(Body(ask + "34"))["features"][0];
  EXPECT_EQ(east["properties"]["green"], 200);
  EXPECT_NEAR(east["geometry"]["coordinates"][0].get<double>(), -179.81875, 1e-6);
}

// The schema of 1.3.0 refuses a document with longitudes beyond 180 degrees.
TEST_F(AllMapsTest, WmsCapabilitiesOfAMapAcrossTheAntimeridianFitTheirSchema) {
  const std::string flight = sample_.NewFlight();
  sample_.PublishAt({179.75, 0.1, 180.25, 0.3}, flight, {{10, 1023, 512, PlainTile(200, 10, 20)}});
  for (const std::string& path : {"/wms/" + flight, std::string("/wms")}) {
    const std::string text = Body(path + "?REQUEST=GetCapabilities&VERSION=1.3.0");
    EXPECT_NE(text.find("<westBoundLongitude>-180.000000000</westBoundLongitude>"
                        "<eastBoundLongitude>180.000000000</eastBoundLongitude>"
                        "<southBoundLatitude>0.100000000</southBoundLatitude>"),
              std::string::npos)
        << path;
    EXPECT_EQ(text.find("<eastBoundLongitude>180.25"), std::string::npos) << path;
    EXPECT_NE(text.find("CRS=\"EPSG:4326\" minx=\"0.100000000\" miny=\"179.750000000\" "
                        "maxx=\"0.300000000\" maxy=\"180.250000000\""),
              std::string::npos)
        << path;
  }
}

// Programs draw tiles within bounds alone, and those of TileJSON neither go on beyond 180 degrees nor wrap.
TEST_F(AllMapsTest, TileJsonOfAMapAcrossTheAntimeridianGoesAroundTheEarth) {
  const std::string flight = sample_.NewFlight();
  sample_.PublishAt({179.75, 0.125, 180.5, 0.25}, flight, {{10, 1023, 511, PlainTile(200, 10, 20)}});
  const json alone = json::parse(Body("/tiles/" + flight + ".json"));
  const json listed = json::parse(Body("/tiles/index.json"))[0];
  for (const json& document : {alone, listed}) {
    EXPECT_EQ(document["bounds"], json::parse("[-180.0,0.125,180.0,0.25]"));
    EXPECT_EQ(document["center"][0], -179.875);
    EXPECT_EQ(document["across_bounds"], json::parse("[179.75,0.125,180.5,0.25]"));
  }
  EXPECT_FALSE(json::parse(Body("/tiles/" + red_ + ".json")).contains("across_bounds"));
}

TEST_F(AllMapsTest, WmsHasTheBackgroundThatIsAskedFor) {
  const std::string beside =
      "/wms?REQUEST=GetMap&VERSION=1.3.0&STYLES=&CRS=CRS:84&BBOX=10,10,80,60"
      "&WIDTH=100&HEIGHT=90&LAYERS=" +
      red_;
  const std::string png = beside + "&FORMAT=image/png";
  EXPECT_EQ(PixelOf(png), (std::array{255, 255, 255, 255}));
  EXPECT_EQ(PixelOf(png + "&bgcolor="), (std::array{255, 255, 255, 255}));
  EXPECT_EQ(PixelOf(png + "&BGCOLOR=0x102030"), (std::array{0x10, 0x20, 0x30, 255}));
  EXPECT_EQ(PixelOf(png + "&BGCOLOR=0x102030&TRANSPARENT=TRUE")[3], 0);
  // JPEG has nothing transparent.
  for (const char* rest : {"", "&TRANSPARENT=TRUE"})
    EXPECT_NEAR(PixelOf(beside + "&FORMAT=image/jpeg&BGCOLOR=0x102030" + rest)[2], 0x30, 3) << rest;
  EXPECT_EQ(sample_.Get(png + "&BGCOLOR=0x10").status, 400);
}

TEST_F(AllMapsTest, FeatureInfoSaysWhatIsUnderAPixel) {
  const std::string ask = std::string("/wms?REQUEST=GetFeatureInfo&VERSION=1.3.0&I=50&J=45") + kBox +
                          "&LAYERS=" + red_ + "&QUERY_LAYERS=" + red_;
  const json answer = json::parse(Body(ask));
  ASSERT_EQ(answer["features"].size(), 1u);
  EXPECT_EQ(answer["features"][0]["properties"]["red"], 200);
  EXPECT_EQ(answer["features"][0]["id"], red_);
  EXPECT_NE(Body(ask + "&INFO_FORMAT=text/plain").find("green = 10"), std::string::npos);
  EXPECT_NE(Body(ask + "&INFO_FORMAT=text/html").find("<td>200</td>"), std::string::npos);
  EXPECT_EQ(sample_.Get(ask + "&INFO_FORMAT=image/png").status, 400);
  const std::string own = std::string("/wms/") + red_ +
                          "?REQUEST=GetFeatureInfo&VERSION=1.1.1&SRS=EPSG:4326" +
                          "&BBOX=-80,10,-10,60&WIDTH=100&HEIGHT=90&QUERY_LAYERS=map";
  EXPECT_EQ(json::parse(Body(own + "&X=50&Y=45"))["features"][0]["properties"]["blue"], 20);
  for (const char* pixel : {"", "&X=100&Y=1", "&X=-1&Y=1", "&X=1.5&Y=1", "&X=1&Y=1e9"})
    EXPECT_EQ(sample_.Get(own + pixel).status, 400) << pixel;
  const std::string tile =
      "/wmts?Request=GetFeatureInfo&TileMatrixSet=WebMercatorQuad&TileMatrix=2&TileRow=1&TileCol=1"
      "&Format=image/png&InfoFormat=application/json&Layer=" +
      red_;
  EXPECT_EQ(json::parse(Body(tile + "&I=3&J=4"))["features"][0]["properties"]["red"], 200);
  EXPECT_EQ(sample_.Get(tile + "&I=256&J=4").status, 400);
  EXPECT_EQ(sample_.Get(tile).status, 400);
}

TEST(FeatureInfo, SaysNoErrorOfAPhotoInAMapWhosePlaceNothingSupports) {
  MapPoint point;
  point.photo.emplace().photo = "a.jpg";
  for (const char* type : kInfoFormats) {
    point.photo->sigma_m.reset();
    const std::string unsupported = InfoResponse({point}, type).body;
    EXPECT_NE(unsupported.find("a.jpg"), std::string::npos) << type;
    EXPECT_EQ(unsupported.find("sigma_m"), std::string::npos) << type;
    point.photo->sigma_m = 2.5;
    EXPECT_NE(InfoResponse({point}, type).body.find("sigma_m"), std::string::npos) << type;
  }
}

TEST_F(AllMapsTest, PointsTellTheColour) {
  const std::string at = "/api/v1/flights/" + red_ + "/point";
  const json inside = json::parse(Body(at + "?lon=-45&lat=40"));
  EXPECT_EQ(inside["colour"], json::parse(R"({"red":200,"green":10,"blue":20,"alpha":255})"));
  EXPECT_TRUE(inside["photo"].is_null());
  EXPECT_TRUE(json::parse(Body(at + "?lon=100&lat=40"))["colour"].is_null());
  EXPECT_TRUE(json::parse(Body(at + "?lon=0&lat=90"))["colour"].is_null());
  for (const char* query :
       {"", "?lon=1", "?lon=x&lat=1", "?lon=1&lat=91", "?lon=1e9&lat=1", "?lon=nan&lat=1"})
    EXPECT_EQ(sample_.Get(at + query).status, 400) << query;
  EXPECT_EQ(sample_.Get("/api/v1/flights/" + without_ + "/point?lon=1&lat=1").status, 404);
}

TEST_F(AllMapsTest, TheListOfTileJsonHasPages) {
  const json all = json::parse(Body("/tiles/index.json"));
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[0]["id"], large_);
  EXPECT_EQ(all[0]["tileSize"], 512);
  const json alone = json::parse(Body("/tiles/" + large_ + ".json"));
  for (const auto& [key, value] : alone.items()) {
    // What else can be made of it is said by the map's own.
    if (key == "bands" || key == "indices" || key == "heights") continue;
    EXPECT_EQ(all[0][key], value) << key;
  }
  const Response first = sample_.Get("/tiles/index.json?limit=1");
  EXPECT_EQ(json::parse(first.body).size(), 1u);
  const std::string link(first.headers.Find("Link"));
  const std::string next = link.substr(std::string("<http://127.0.0.1:1").size(), link.find('>') - 19);
  EXPECT_EQ(json::parse(Body(next))[0]["id"], red_);
  for (const char* query : {"?limit=-1", "?limit=0", "?cursor=.."})
    EXPECT_EQ(sample_.Get(std::string("/tiles/index.json") + query).status, 400) << query;
}

TEST_F(AllMapsTest, ATokenOfOneFlightSeesThatOne) {
  const Headers share = sample_.MakeToken("shared", storage::Scope::kRead, {}, red_);
  for (const char* path : {"/wmts", "/wms", "/tiles/index.json", "/wmts/1.0.0/WMTSCapabilities.xml"}) {
    EXPECT_EQ(sample_.Get(path).status, 401) << path;
    const std::string text = Body(path, share);
    EXPECT_NE(text.find(red_), std::string::npos) << path;
    EXPECT_EQ(text.find(large_), std::string::npos) << path;
  }
  const std::string get = std::string("/wms?REQUEST=GetMap&VERSION=1.3.0") + kBox + "&LAYERS=";
  EXPECT_EQ(sample_.Get(get + red_, share).status, 200);
  EXPECT_EQ(sample_.Get(get + large_, share).status, 400);
  EXPECT_EQ(sample_.Get(get + red_ + "," + large_, share).status, 400);
  const std::string tile =
      "/wmts?Request=GetTile&TileMatrixSet=WebMercatorQuad&TileMatrix=2&TileRow=1&TileCol=1"
      "&Format=image/png&Layer=";
  EXPECT_EQ(sample_.Get(tile + red_, share).status, 200);
  EXPECT_EQ(sample_.Get(tile + large_, share).status, 400);
}

}  // namespace
}  // namespace skyquilt::api
