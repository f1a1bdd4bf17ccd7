// What a map shows within a polygon: areas against known ones, colours against painted tiles.
#include "api/tiles/recode_tile.h"
#include "core/geo/geodesic.h"
#include "core/geo/tile_id.h"
#include "tests/api/sample_service.h"

namespace skyquilt::api {
namespace {

using nlohmann::json;

// A tile whose red is that of its column and whose lower half shows nothing.
std::string HalfTile() {
  image::RgbaImage tile = image::RgbaImage::Transparent(256, 256);
  for (int row = 0; row < 128; ++row) {
    for (int column = 0; column < 256; ++column) {
      std::uint8_t* pixel = tile.Pixel(column, row);
      pixel[0] = static_cast<std::uint8_t>(column);
      pixel[1] = 7;
      pixel[3] = 255;
    }
  }
  return EncodeTile(std::move(tile), image::PictureFormat::kPng);
}

class StatisticsTest : public testing::Test {
 protected:
  // Tile 10/512/511, north and east of where the equator meets Greenwich.
  StatisticsTest() {
    sample_.PublishAt({0.0, 0.0, kTileDeg, kTileDeg}, flight_, {{10, 512, 512, HalfTile()}});
  }
  Response Post(const std::string& body, Headers headers = {}, const char* type = "application/geo+json") {
    headers.Add("Content-Type", type);
    return sample_.Send(Method::kPost, "/api/v1/flights/" + flight_ + "/statistics", body,
                        std::move(headers));
  }
  static std::string Box(double west, double south, double east, double north) {
    return json{{"type", "Polygon"},
                {"coordinates",
                 json::array({{{west, south}, {east, south}, {east, north}, {west, north}, {west, south}}})}}
        .dump();
  }

  static constexpr double kTileDeg = 360.0 / 1024;
  SampleService sample_;
  std::string flight_ = sample_.NewFlight();
};

TEST_F(StatisticsTest, CountsWhatLiesWithin) {
  const Response response = Post(Box(0, 0, kTileDeg / 2, 1));
  ASSERT_EQ(response.status, 200) << response.body;
  const json told = json::parse(response.body);
  EXPECT_EQ(told["pixels"], 128 * 128);
  EXPECT_EQ(told["zoom"], 10);
  const json& red = told["bands"][0];
  EXPECT_EQ(red["min"], 0);
  EXPECT_EQ(red["max"], 127);
  EXPECT_DOUBLE_EQ(red["mean"], 63.5);
  EXPECT_NEAR(red["std"].get<double>(), std::sqrt((128.0 * 128 - 1) / 12), 1e-9);
  EXPECT_EQ(red["histogram"][3], 128);
  EXPECT_EQ(red["histogram"][200], 0);
  EXPECT_EQ(told["bands"][1]["mean"], 7.0);
  EXPECT_EQ(told["bands"][2]["max"], 0);
  // A quarter of the tile; its side is 39.1 km along the equator.
  const double side_m = 40075016.6856 / 1024;
  EXPECT_NEAR(told["covered_m2"].get<double>() / (side_m * side_m / 4), 0.9933, 0.001);
}

TEST_F(StatisticsTest, AreasAreThoseOfTheEllipsoid) {
  // One degree at the equator (GeographicLib's Planimeter).
  EXPECT_NEAR(json::parse(Post(Box(0, 0, 1, 1)).body)["area_m2"].get<double>() / 12308778361.469, 1.0, 1e-9);
  EXPECT_NEAR(
      geo::GeodesicAreaM2(
          {{.lat_deg = 0, .lon_deg = 0}, {.lat_deg = 0, .lon_deg = 90}, {.lat_deg = 90, .lon_deg = 0}}) /
          (510065621724088.5 / 8),
      1.0, 1e-9);
  const json holed = {
      {"type", "Polygon"},
      {"coordinates",
       {{{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 0}}, {{0, 0}, {0.5, 0}, {0.5, 0.5}, {0, 0.5}, {0, 0}}}}};
  const json told = json::parse(Post(holed.dump()).body);
  EXPECT_NEAR(told["area_m2"].get<double>() / 12308778361.469, 0.75, 1e-3);
  EXPECT_EQ(told["pixels"], 0);  // the map lies in the hole
  EXPECT_TRUE(told["bands"][0]["mean"].is_null());
}

TEST_F(StatisticsTest, BesideTheMapThereIsNothing) {
  const json told = json::parse(Post(Box(10, 10, 11, 11)).body);
  EXPECT_EQ(told["pixels"], 0);
  EXPECT_EQ(told["covered_m2"], 0.0);
  EXPECT_EQ(json::parse(Post(Box(-180, -90, 180, 90)).body)["pixels"], 256 * 128);  // the world
}

// GeoJSON cuts what lies across the antimeridian in two.
TEST_F(StatisticsTest, OfAMapAcrossTheAntimeridianBothSidesCount) {
  flight_ = sample_.NewFlight();
  sample_.PublishAt({180.0 - kTileDeg, 0.0, 180.0 + kTileDeg, kTileDeg}, flight_,
                    {{10, 1023, 512, HalfTile()}, {10, 0, 512, HalfTile()}});
  const std::string west = Box(180.0 - kTileDeg, 0, 180, 1), east = Box(-180, 0, -180 + kTileDeg / 2, 1);
  EXPECT_EQ(json::parse(Post(west).body)["pixels"], 256 * 128);
  EXPECT_EQ(json::parse(Post(east).body)["pixels"], 128 * 128);
  const json both = {
      {"type", "MultiPolygon"},
      {"coordinates", json::array({json::parse(west)["coordinates"], json::parse(east)["coordinates"]})}};
  EXPECT_EQ(json::parse(Post(both.dump()).body)["pixels"], (256 + 128) * 128);
}

TEST_F(StatisticsTest, RefusesWhatIsNoPolygon) {
  for (const char* body : {"", "x", "[]", "7"}) EXPECT_EQ(Post(body).status, 400) << body;
  for (const char* body :
       {"{}", R"({"type":"Point","coordinates":[1,1]})", R"({"type":"Polygon","coordinates":[]})",
        R"({"type":"Polygon","coordinates":[[[0,0],[1,1e9],[1,1],[0,0]]]})",
        R"({"type":"Polygon","coordinates":[[[0,0],[1,1],[1,0],[0,1],[0,0]]]})"}) {
    EXPECT_EQ(Post(body).status, 422) << body;
  }
  EXPECT_EQ(Post(Box(0, 0, 1, 1), {}, "text/plain").status, 415);
  EXPECT_EQ(sample_.Send(Method::kPost, "/api/v1/flights/nothing/statistics", Box(0, 0, 1, 1)).status, 404);
}

TEST_F(StatisticsTest, AreForWhoMayRead) {
  const Headers share = sample_.MakeToken("shared", storage::Scope::kRead, {}, flight_);
  EXPECT_EQ(Post(Box(0, 0, 1, 1), share).status, 200);
  EXPECT_EQ(Post(Box(0, 0, 1, 1)).status, 401);
  const Headers other = sample_.MakeToken("other", storage::Scope::kRead, {}, sample_.NewFlight());
  EXPECT_EQ(Post(Box(0, 0, 1, 1), other).status, 404);
}

}  // namespace
}  // namespace skyquilt::api
