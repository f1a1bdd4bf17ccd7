// A map's photos as features: points and footprints, by box, time and page.
#include <fstream>

#include "api/tiles/recode_tile.h"
#include "tests/api/sample_service.h"

namespace skyquilt::api {
namespace {

using nlohmann::json;

class FeaturesTest : public testing::Test {
 protected:
  FeaturesTest() {
    storage::Revision facts;
    facts.bounds = {7.0, 46.0, 7.1, 46.1};
    facts.photos_total = 3;
    const std::int64_t revision = sample_.Publish(flight_, {{2, 1, 2, TransparentPng(256)}}, 256, facts);
    file_ = sample_.dir().Revision(flight_, revision) / "photos.geojson";
    json features = json::array();
    for (int i = 0; i < 3; ++i) {
      const double lon = 7.0 + 0.01 * i, lat = 46.05;
      const json ring = {{lon - 0.001, lat - 0.001},
                         {lon + 0.001, lat - 0.001},
                         {lon + 0.001, lat + 0.001},
                         {lon - 0.001, lat - 0.001}};
      json photo = {{"type", "Feature"},
                    {"geometry", {{"type", "Polygon"}, {"coordinates", json::array({ring})}}},
                    {"properties",
                     {{"name", "photo " + std::to_string(i) + ".jpg"},
                      {"camera_lon", lon},
                      {"camera_lat", lat},
                      {"captured_at", "2024-06-01T10:0" + std::to_string(i) + ":00Z"}}}};
      if (i == 2) photo["geometry"] = nullptr;  // it looks towards the horizon
      features.push_back(photo);
    }
    std::ofstream(file_) << json{{"type", "FeatureCollection"}, {"features", features}};
  }
  json Items(const std::string& query, const std::string& kind = ".photos") {
    return sample_.Json("/ogc/collections/" + flight_ + kind + "/items" + query);
  }

  SampleService sample_;
  std::string flight_ = sample_.NewFlight();
  std::filesystem::path file_;
};

TEST_F(FeaturesTest, CollectionsAreListedAndDescribed) {
  const json list = json::parse(sample_.Get("/ogc/collections").body)["collections"];
  ASSERT_EQ(list.size(), 3u);
  for (const json& one : list) {
    const std::string id = one["id"];
    EXPECT_EQ(json::parse(sample_.Get("/ogc/collections/" + id).body), one) << id;
  }
  EXPECT_EQ(list[1]["itemType"], "feature");
  // More than there may be on a page is no mistake, as of the other lists of OGC API and STAC.
  EXPECT_EQ(json::parse(sample_.Get("/ogc/collections?limit=1000").body)["collections"], list);
  EXPECT_EQ(sample_.Get("/ogc/collections?limit=0").status, 400);
  EXPECT_EQ(sample_.Get("/ogc/collections/" + flight_ + ".others").status, 404);
  // A map without photos is one collection.
  const std::string imported = sample_.NewFlight();
  sample_.Publish(imported, {{2, 1, 2, TransparentPng(256)}});
  EXPECT_EQ(json::parse(sample_.Get("/ogc/collections").body)["collections"].size(), 4u);
  EXPECT_EQ(sample_.Get("/ogc/collections/" + imported + ".photos").status, 404);
}

TEST_F(FeaturesTest, AreListedByBoxAndTime) {
  const json points = Items("");
  ASSERT_EQ(points["features"].size(), 3u);
  EXPECT_EQ(points["numberMatched"], 3);
  EXPECT_EQ(points["features"][1]["geometry"], json::parse(R"({"type":"Point","coordinates":[7.01,46.05]})"));
  EXPECT_EQ(Items("", ".footprints")["features"].size(), 2u);
  EXPECT_EQ(Items("?bbox=7.005,46,7.015,47")["features"][0]["id"], "photo 1.jpg");
  EXPECT_EQ(Items("?bbox=7.0005,46,7.0006,47")["numberMatched"], 0);
  EXPECT_EQ(Items("?bbox=7.0005,46,7.0006,47", ".footprints")["numberMatched"], 1);
  EXPECT_EQ(Items("?datetime=2024-06-01T10:01:00Z/..")["numberMatched"], 2);
  EXPECT_EQ(Items("?datetime=2024-06-01T12:01:00%2B02:00")["numberMatched"], 1);
}

TEST_F(FeaturesTest, PagesLeadToTheLast) {
  const json first = Items("?limit=2&bbox=6,45,8,47");
  EXPECT_EQ(first["numberReturned"], 2);
  std::string next;
  for (const json& link : first["links"]) {
    if (link["rel"] == "next") next = link["href"].get<std::string>().substr(18);
  }
  const json second = json::parse(sample_.Get(next).body);
  ASSERT_EQ(second["features"].size(), 1u);
  for (const json& link : second["links"]) EXPECT_NE(link["rel"], "next");
  const json one =
      json::parse(sample_.Get("/ogc/collections/" + flight_ + ".photos/items/photo%202.jpg").body);
  EXPECT_EQ(one["properties"], second["features"][0]["properties"]);
  EXPECT_EQ(sample_.Get("/ogc/collections/" + flight_ + ".footprints/items/photo%202.jpg").status, 404);
  EXPECT_EQ(Items("?offset=99999999")["numberReturned"], 0);
}

TEST_F(FeaturesTest, RefuseWhatCannotBeMeant) {
  const std::string at = "/ogc/collections/" + flight_ + ".photos/items";
  for (const char* query : {"?limit=-1", "?limit=0", "?offset=-1", "?bbox=1", "?bbox=1e9,0,1,1",
                            "?datetime=x", "?colour=red", "?bbox-crs=EPSG:999999"}) {
    EXPECT_EQ(sample_.Get(at + query).status, 400) << query;
  }
  EXPECT_EQ(sample_.Get(at + "?f=html").status, 406);
  EXPECT_EQ(sample_.Get("/ogc/collections/" + flight_ + "/items").status, 404);
  EXPECT_EQ(sample_.Get("/ogc/collections/nothing.photos/items").status, 404);
}

TEST_F(FeaturesTest, ADamagedListIsSaidToBeOne) {
  for (const char* text : {"", "[", "[]", R"({"features":7})", R"({"features":[7]})", R"({"features":[{}]})",
                           R"({"features":[{"properties":{"name":1}}]})"}) {
    std::ofstream(file_) << text;
    EXPECT_EQ(sample_.Get("/ogc/collections/" + flight_ + ".photos/items").status, 422) << text;
    EXPECT_GE(sample_.Get("/ogc/collections/" + flight_ + ".photos/items/a").status, 404) << text;
  }
}

TEST_F(FeaturesTest, ATokenOfAnotherFlightSeesNothing) {
  const Headers share = sample_.MakeToken("shared", storage::Scope::kRead, {}, sample_.NewFlight());
  EXPECT_EQ(sample_.Get("/ogc/collections/" + flight_ + ".photos/items", share).status, 404);
}

}  // namespace
}  // namespace skyquilt::api
