// Indices of maps: tiles in colours, values at a place and within a polygon, bands, legends, zones, styles of
// WMS and WMTS; of a map of colours and of one with bands of its own.
#include <algorithm>
#include <cmath>
#include <fstream>

#include "api/tiles/recode_tile.h"
#include "core/geo/web_mercator.h"
#include "core/indices/colour_ramp.h"
#include "tests/api/sample_service.h"
#include "tests/storage/rasters/band_file.h"

namespace skyquilt::api {
namespace {

using nlohmann::json;

constexpr double kTileDeg = 360.0 / 1024;

// Green grows from west to east, red from north to south; the last quarter of the rows shows nothing.
std::string FieldTile() {
  image::RgbaImage tile = image::RgbaImage::Transparent(256, 256);
  for (int row = 0; row < 192; ++row) {
    for (int column = 0; column < 256; ++column) {
      std::uint8_t* pixel = tile.Pixel(column, row);
      pixel[0] = static_cast<std::uint8_t>(row);
      pixel[1] = static_cast<std::uint8_t>(column);
      pixel[2] = 30;
      pixel[3] = 255;
    }
  }
  return EncodeTile(std::move(tile), image::PictureFormat::kPng);
}

class IndicesTest : public testing::Test {
 protected:
  // Tile 10/512/511, north and east of where the equator meets Greenwich.
  IndicesTest() {
    revision_ = sample_.PublishAt({0.0, 0.0, kTileDeg, kTileDeg}, flight_, {{10, 512, 512, FieldTile()}});
  }

  // Near infrared grows from west to east, red is a tenth; the northern half is not known.
  void AddBands(std::string fourth = "rededge", int width_px = 256) {
    const double pixel_m = geo::PixelSizeInMercM(10, 256);
    test::WriteBandFile(sample_.dir().Revision(flight_, revision_) / "bands.tif",
                        {0.0,
                         256 * pixel_m,
                         pixel_m,
                         width_px,
                         256,
                         {"green", "red", std::move(fourth), "nir"},
                         [](int band, int column, int row) {
                           if (row < 128) return std::nanf("");
                           return band == 3 ? static_cast<float>(column) / 255.0f : 0.1f;
                         }});
  }

  std::string Tile(const std::string& query) { return "/tiles/" + flight_ + "/10/512/511.png?" + query; }
  image::RgbaImage Picture(const std::string& target) { return sample_.Picture(target); }
  json Json(const std::string& target) { return sample_.Json(target); }
  std::string Refusal(const std::string& target, int status = 400) {
    const Response response = sample_.Get(target);
    EXPECT_EQ(response.status, status) << target << response.body;
    return json::parse(response.body, nullptr, false).value("detail", "");
  }
  json Statistics(const std::string& query, double north_deg = kTileDeg) {
    const json box = {{"type", "Polygon"},
                      {"coordinates",
                       {{{0.0, 0.0}, {kTileDeg, 0.0}, {kTileDeg, north_deg}, {0.0, north_deg}, {0.0, 0.0}}}}};
    const Response response =
        sample_.Send(Method::kPost, "/api/v1/flights/" + flight_ + "/statistics?" + query, box.dump(),
                     {{"Content-Type", "application/geo+json"}});
    EXPECT_EQ(response.status, 200) << response.body;
    return json::parse(response.body, nullptr, false);
  }

  SampleService sample_;
  std::string flight_ = sample_.NewFlight();
  std::int64_t revision_ = 0;
};

TEST_F(IndicesTest, TilesOfColoursHaveTheColoursOfTheirValues) {
  const image::RgbaImage picture =
      Picture(Tile("expression=(green-red)/(green%2Bred-blue)&rescale=-0.5,0.5&colormap=viridis"));
  const indices::ColourRamp ramp = *indices::ColourRamp::Named("viridis");
  int compared = 0;
  for (int row = 0; row < 256; row += 3) {
    for (int column = 0; column < 256; column += 5) {
      const std::uint8_t* pixel = picture.Pixel(column, row);
      if (column + row == 30) continue;  // hardly a value: what is divided by is zero, or all but
      if (row >= 192) {
        EXPECT_EQ(pixel[3], 0) << column << " " << row;
        continue;
      }
      const double value = double(column - row) / (column + row - 30);
      const int level = indices::ColourRamp::LevelOf(value, -0.5, 0.5);
      EXPECT_EQ(pixel[3], 255);
      for (std::size_t c = 0; c < 3; ++c)
        EXPECT_NEAR(pixel[c], ramp.At(level)[c], 3) << column << " " << row;  // one level
      ++compared;
    }
  }
  EXPECT_GT(compared, 3000);
  // A plus that no client encoded.
  EXPECT_EQ(
      sample_.Get(Tile("expression=(green-red)/(green+red-blue)&rescale=-0.5,0.5&colormap=viridis")).body,
      sample_.Get(Tile("index=vari&rescale=-0.5,0.5&colormap=VIRIDIS")).body);
}

TEST_F(IndicesTest, TilesAreTaggedCachedAndToBeHadInOtherSizes) {
  const Response first = sample_.Get(Tile("index=vari"));
  const std::string etag(first.headers.Find("ETag"));
  EXPECT_FALSE(etag.empty());
  EXPECT_EQ(sample_.Get(Tile("index=vari"), {{"If-None-Match", etag}}).status, 304);
  EXPECT_EQ(sample_.Get(Tile("index=gli"), {{"If-None-Match", etag}}).status, 200);
  EXPECT_EQ(sample_.Get(Tile("index=vari&colormap=rdylgn_r"), {{"If-None-Match", etag}}).status, 200);
  const auto kept = sample_.service().made_tiles.kept().tiles;
  sample_.Get(Tile("index=vari"));
  EXPECT_EQ(sample_.service().made_tiles.kept().tiles, kept);
  EXPECT_EQ(Picture("/tiles/" + flight_ + "/10/512/511@2x.png?index=vari").width_px, 512);
  EXPECT_EQ(sample_.Get("/tiles/" + flight_ + "/10/512/511.webp?index=vari").headers.Find("Content-Type"),
            "image/webp");
  EXPECT_EQ(sample_.Get("/tiles/" + flight_ + "/10/600/511.png?index=vari").status, 404);
  const Response immutable = sample_.Get(Tile("index=vari&rev=" + std::to_string(revision_)));
  EXPECT_NE(immutable.headers.Find("Cache-Control").find("immutable"), std::string::npos);
}

TEST_F(IndicesTest, TilesReachAsFarAsTheBandsDo) {
  const std::string east = "/tiles/" + flight_ + "/10/513/511.png?index=ndvi";
  AddBands("rededge", 512);  // one more tile to the east, of which the map has nothing
  EXPECT_EQ(sample_.Get("/tiles/" + flight_ + "/10/513/511.png?empty=204").status, 204);
  EXPECT_EQ(Picture(east).Pixel(9, 200)[3], 255);
  EXPECT_EQ(Picture(east).Pixel(9, 9)[3], 0);
  EXPECT_EQ(sample_.Get("/tiles/" + flight_ + "/10/516/511.png?index=ndvi").status, 404);
  const json bounds = Json("/tiles/" + flight_ + ".json?index=ndvi")["bounds"];
  EXPECT_NEAR(bounds[0], 0.0, 1e-9);
  EXPECT_NEAR(bounds[2], 2 * kTileDeg, 1e-9);
  const json map = Json("/tiles/" + flight_ + ".json");
  EXPECT_EQ(map["bands_bounds"], bounds);
  EXPECT_NEAR(map["bounds"][2], kTileDeg, 1e-9);
}

TEST_F(IndicesTest, HostileRequestsAreTaughtBetter) {
  EXPECT_NE(Refusal(Tile("index=ndvi")).find("no band \"nir\". It has red, green, blue"), std::string::npos);
  EXPECT_NE(Refusal(Tile("index=evi")).find("ndvi, ndre"), std::string::npos);
  EXPECT_NE(Refusal(Tile("index=vari&expression=red")).find("not by both"), std::string::npos);
  EXPECT_NE(Refusal(Tile("colormap=viridis")).find("say which"), std::string::npos);
  EXPECT_NE(Refusal(Tile("index=vari&colormap=rainbow")).find("viridis"), std::string::npos);
  for (const char* rescale :
       {"1", "1,1", "2,1", "a,b", "0,1,2", "nan,1", "-inf,inf", "", ",", "0,", "0,1e300"})
    EXPECT_NE(Refusal(Tile(std::string("index=vari&rescale=") + rescale)).find("two numbers"),
              std::string::npos)
        << rescale;
  for (const std::string& text :
       {std::string(), std::string("((((("), std::string(600, '('), std::string("red/"), std::string("1/0"),
        std::string("system('x')"), std::string("red;green")})
    EXPECT_NE(Refusal(Tile("expression=" + text)).find("expression"), std::string::npos) << text;
  EXPECT_NE(Refusal("/tiles/" + flight_ + ".json?index=ndvi").find("no band"), std::string::npos);
  EXPECT_NE(Refusal("/api/v1/flights/" + flight_ + "/point?lon=0.1&lat=0.2&index=ndvi").find("no band"),
            std::string::npos);
  EXPECT_NE(Refusal("/api/v1/flights/" + flight_ + "/legend.svg").find("Say which"), std::string::npos);
  EXPECT_EQ(sample_.Get(Tile("index=vari&rescale=0,1&colormap_name=greys")).status, 200);
}

TEST_F(IndicesTest, DocumentsSayWhichIndicesThereAre) {
  const json bands = Json("/api/v1/flights/" + flight_ + "/bands");
  EXPECT_EQ(bands["bands"], json({"red", "green", "blue"}));
  EXPECT_EQ(bands["indices"].size(), 3u);
  EXPECT_EQ(bands["indices"][0]["id"], "vari");
  EXPECT_EQ(bands["colormaps"][0]["colours"].size(), 17u);
  const json map = Json("/tiles/" + flight_ + ".json");
  EXPECT_EQ(map["bands"], bands["bands"]);
  EXPECT_EQ(map["indices"][0]["id"], "vari");
  const json index = Json("/tiles/" + flight_ + ".json?expression=red%2Bgreen&rescale=0,2&colormap=magma_r");
  const std::string address = index["tiles"][0];
  EXPECT_NE(address.find("/{z}/{x}/{y}.png?rev="), std::string::npos) << address;
  EXPECT_NE(address.find("&expression=red%2Bgreen&rescale=0,2&colormap=magma_r"), std::string::npos)
      << address;
  EXPECT_EQ(index["index"]["rescale"], json({0.0, 2.0}));
  EXPECT_EQ(index["name"], "field, red+green");
  Response legend =
      sample_.Get("/api/v1/flights/" + flight_ + "/legend.svg?expression=min(red,green)&rescale=0,2");
  EXPECT_EQ(legend.headers.Find("Content-Type"), "image/svg+xml");
  EXPECT_NE(legend.body.find(">1.5</text>"), std::string::npos) << legend.body;
  legend = sample_.Get("/api/v1/flights/" + flight_ + "/legend.svg?expression=red&rescale=300,301");
  for (const char* mark : {">300</text>", ">300.25</text>", ">300.5</text>", ">300.75</text>", ">301</text>"})
    EXPECT_NE(legend.body.find(mark), std::string::npos) << legend.body;
  EXPECT_EQ(sample_.Get("/api/v1/flights/nothing/legend.svg?index=vari").status, 404);
  EXPECT_EQ(sample_.Get("/api/v1/flights/nothing/legend.png?index=vari").status, 404);
}

TEST_F(IndicesTest, PlacesAndPolygonsHaveValues) {
  const double lat = geo::LatLonFromMerc({0.0, geo::PixelSizeInMercM(10, 256) * (256 - 100.5)}).lat_deg;
  const std::string at = "/api/v1/flights/" + flight_ + "/point?lat=" + std::to_string(lat) +
                         "&lon=" + std::to_string(kTileDeg * 200.5 / 256);
  EXPECT_NEAR(Json(at + "&index=vari")["index"]["value"].get<double>(), 100.0 / 270.0, 1e-6);
  EXPECT_NEAR(Json(at + "&expression=red&ground=false")["index"]["value"].get<double>(), 100.0 / 255, 1e-6);
  EXPECT_FALSE(Json(at).contains("index"));
  EXPECT_TRUE(
      Json("/api/v1/flights/" + flight_ + "/point?lat=0.01&lon=0.1&index=vari")["index"]["value"].is_null());
  EXPECT_EQ(sample_.Get(at + "&ground=maybe").status, 400);
  const json told = Statistics("expression=green");
  EXPECT_EQ(told["index"]["pixels"], 256 * 192);
  EXPECT_NEAR(told["index"]["mean"].get<double>(), 0.5, 1e-6);
  EXPECT_NEAR(told["index"]["std"].get<double>(), std::sqrt((256.0 * 256 - 1) / 12) / 255, 1e-6);
  EXPECT_NEAR(told["index"]["percentiles"]["p25"].get<double>(), 0.25, 0.003);
  EXPECT_EQ(told["index"]["max"], 1.0);
  std::int64_t counted = 0;
  for (const auto& bin : told["index"]["histogram"]) counted += bin.get<std::int64_t>();
  EXPECT_EQ(counted, 256 * 192);
  EXPECT_EQ(told["bands"][1]["max"], 255);
  EXPECT_FALSE(Statistics("").contains("index"));
  EXPECT_TRUE(Statistics("index=vari", 0.01)["index"]["mean"].is_null());
}

TEST_F(IndicesTest, BandsOfTheirOwnTakeThePlaceOfColours) {
  AddBands();
  const json bands = Json("/api/v1/flights/" + flight_ + "/bands");
  EXPECT_EQ(bands["bands"], json({"green", "red", "rededge", "nir"}));
  EXPECT_EQ(bands["indices"].size(), 4u);
  const image::RgbaImage picture = Picture(Tile("index=ndvi&rescale=-1,1&colormap=greys_r"));
  const indices::ColourRamp ramp = *indices::ColourRamp::Named("greys_r");
  EXPECT_EQ(picture.Pixel(100, 50)[3], 0);
  for (int column = 0; column < 256; ++column) {
    const double nir = column / 255.0;
    const int level = indices::ColourRamp::LevelOf((nir - 0.1) / (nir + 0.1), -1, 1);
    EXPECT_NEAR(picture.Pixel(column, 150)[0], ramp.At(level)[0], 3) << column;
    EXPECT_EQ(picture.Pixel(column, 250)[3], 255) << column;  // the map's own tile shows nothing here
  }
  EXPECT_NE(Refusal(Tile("index=vari")).find("no band \"blue\""), std::string::npos);
  EXPECT_EQ(Statistics("expression=nir")["index"]["pixels"], 256 * 128);
  EXPECT_NEAR(Json("/api/v1/flights/" + flight_ + "/point?lat=0.1&lon=0.2&expression=red")["index"]["value"]
                  .get<double>(),
              0.1, 1e-6);
}

TEST_F(IndicesTest, DamagedBandsHarmNoTile) {
  std::ofstream(sample_.dir().Revision(flight_, revision_) / "bands.tif") << "nothing";
  EXPECT_EQ(sample_.Get(Tile("")).status, 200);
  EXPECT_EQ(sample_.Get("/tiles/" + flight_ + ".json").status, 200);
  EXPECT_GE(sample_.Get(Tile("index=ndvi")).status, 400);
}

TEST_F(IndicesTest, WmsAndWmtsHaveStyles) {
  AddBands();
  const std::string capabilities =
      sample_.Get("/wms/" + flight_ + "?service=WMS&request=GetCapabilities").body;
  EXPECT_NE(capabilities.find("<Style><Name>ndre</Name><Title>NDRE</Title><LegendURL"), std::string::npos)
      << capabilities;
  EXPECT_EQ(capabilities.find("<Name>vari</Name>"), std::string::npos);
  const std::string box = std::to_string(geo::TileSizeInMercM(10));
  const std::string map = "/wms/" + flight_ +
                          "?service=WMS&version=1.3.0&request=GetMap&layers=map&crs=EPSG:3857&bbox=0,0," +
                          box + "," + box + "&width=256&height=256&format=image/png&transparent=true&styles=";
  const image::RgbaImage styled = Picture(map + "ndvi"), tile = Picture(Tile("index=ndvi"));
  EXPECT_TRUE(std::equal(styled.rgba.begin(), styled.rgba.end(), tile.rgba.begin(), tile.rgba.end()));
  EXPECT_EQ(Picture(map).Pixel(7, 250)[3], 0);
  for (const char* style : {"vari", "nothing", "ndvi,ndvi"}) {
    const Response refused = sample_.Get(map + style);
    EXPECT_EQ(refused.status, 400) << style;
    EXPECT_NE(refused.body.find("StyleNotDefined"), std::string::npos) << refused.body;
  }
  const std::string wmts = sample_.Get("/wmts/" + flight_ + "/1.0.0/WMTSCapabilities.xml").body;
  EXPECT_NE(wmts.find("<ows:Identifier>ndvi</ows:Identifier><LegendURL"), std::string::npos) << wmts;
  const Response rest = sample_.Get("/wmts/" + flight_ + "/map/ndvi/WebMercatorQuad/10/511/512.png");
  EXPECT_EQ(rest.status, 200) << rest.body;
  EXPECT_EQ(rest.body, sample_.Get(Tile("index=ndvi")).body);
  EXPECT_EQ(sample_.Get("/wmts/" + flight_ + "/map/nothing/WebMercatorQuad/10/511/512.png").status, 400);
  // In the list of all maps too.
  EXPECT_NE(sample_.Get("/wms?service=WMS&request=GetCapabilities").body.find("<Name>ndre</Name>"),
            std::string::npos);
}

TEST_F(IndicesTest, ZonesHaveAsMuchLandEach) {
  const std::string zones = "/api/v1/flights/" + flight_ + "/zones?expression=green&classes=4";
  const json collection = Json(zones);
  ASSERT_EQ(collection["features"].size(), 4u);
  double before = -1.0;
  for (const json& feature : collection["features"]) {
    const json& facts = feature["properties"];
    EXPECT_GT(facts["mean"].get<double>(), before);
    before = facts["mean"];
    EXPECT_NEAR(
        facts["area_m2"].get<double>() / collection["features"][0]["properties"]["area_m2"].get<double>(),
        1.0, 0.06);
    const std::string shape = feature["geometry"]["type"];
    EXPECT_TRUE(shape == "Polygon" || shape == "MultiPolygon") << shape;
  }
  const Response shapes = sample_.Get(zones + "&format=shp");
  EXPECT_EQ(shapes.headers.Find("Content-Type"), "application/zip");
  EXPECT_TRUE(shapes.body.starts_with("PK"));
  for (const char* name : {"zones.shp", "zones.dbf", "zones.prj", "zones.shx"})
    EXPECT_NE(shapes.body.find(name), std::string::npos) << name;
  for (const char* wrong : {"&classes=1", "&classes=100", "&classes=x", "&format=kml", "&resolution_m=0.001",
                            "&resolution_m=-1", "&resolution_m=nan"})
    EXPECT_EQ(sample_.Get("/api/v1/flights/" + flight_ + "/zones?index=vari" + wrong).status, 400) << wrong;
  EXPECT_EQ(sample_.Get("/api/v1/flights/" + flight_ + "/zones").status, 400);
  EXPECT_EQ(sample_.Get("/api/v1/flights/" + flight_ + "/zones?expression=log(red-2)").status, 422);
}

TEST_F(IndicesTest, AreForWhoMayRead) {
  const Headers share = sample_.MakeToken("shared", storage::Scope::kRead, {}, flight_);
  const Headers other = sample_.MakeToken("other", storage::Scope::kRead, {}, sample_.NewFlight());
  for (const std::string& path : {Tile("index=vari"), "/api/v1/flights/" + flight_ + "/bands",
                                  "/api/v1/flights/" + flight_ + "/legend.svg?index=vari",
                                  "/api/v1/flights/" + flight_ + "/legend.png?index=vari",
                                  "/api/v1/flights/" + flight_ + "/zones?index=vari"}) {
    EXPECT_EQ(sample_.Get(path, share).status, 200) << path;
    EXPECT_EQ(sample_.Get(path).status, 401) << path;
    EXPECT_EQ(sample_.Get(path, other).status, 404) << path;
  }
}

}  // namespace
}  // namespace skyquilt::api
