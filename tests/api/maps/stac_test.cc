// The catalogue of all maps: what a search finds, page by page, and what a token sees of it.
#include <fstream>
#include <set>

#include "api/tiles/recode_tile.h"
#include "tests/api/sample_service.h"

namespace skyquilt::api {
namespace {

using nlohmann::json;

class StacTest : public testing::Test {
 protected:
  std::string Add(const geo::LatLonBounds& bounds, const std::string& first = "",
                  const std::string& last = "") {
    const std::string flight = sample_.NewFlight();
    storage::Revision facts;
    facts.bounds = bounds;
    facts.gsd_m = 0.05;
    facts.first_capture = first;
    facts.last_capture = last;
    sample_.Publish(flight, {{2, 1, 2, TransparentPng(256)}}, 256, facts);
    return flight;
  }
  json Search(const std::string& query, Headers headers = {}) {
    return sample_.Json("/stac/search" + query, std::move(headers));
  }
  Response Post(const std::string& body) {
    return sample_.Send(Method::kPost, "/stac/search", body, {{"Content-Type", "application/json"}});
  }
  std::set<std::string> Posted(const json& body) {
    const Response response = Post(body.dump());
    EXPECT_EQ(response.status, 200) << body << response.body;
    return Found(json::parse(response.body));
  }
  static std::set<std::string> Found(const json& page) {
    std::set<std::string> flights;
    for (const json& feature : page["features"]) {
      const std::string id = feature["id"];
      flights.insert(id.substr(0, id.find('-')));
    }
    return flights;
  }
  static std::string LinkOf(const json& document, const std::string& rel) {
    for (const json& link : document["links"]) {
      if (link["rel"] == rel)
        return link["href"].get<std::string>().substr(std::string("http://127.0.0.1:1").size());
    }
    return "";
  }

  SampleService sample_;
};

TEST_F(StacTest, HeightsNameTheZoneOfTheirCells) {
  const std::string flight = sample_.NewFlight();
  const std::int64_t revision =
      sample_.PublishAt({7.1, 46.8, 7.2, 46.9}, flight, {{2, 1, 2, TransparentPng(256)}});
  std::ofstream(sample_.dir().Revision(flight, revision) / "dsm_photos.tif") << "of ours";
  const json item = sample_.Json("/stac/" + flight);
  EXPECT_EQ(item["properties"]["proj:epsg"], 3857);
  EXPECT_EQ(item["assets"]["dsm"]["proj:epsg"], 32632);
  EXPECT_FALSE(item["assets"]["cog"].contains("proj:epsg"));
}

using Ids = std::set<std::string>;

TEST_F(StacTest, FindsByBoxShapeTimeAndName) {
  const std::string bern =
      Add({7.40, 46.90, 7.50, 46.95}, "2024-06-01T10:00:00+02:00", "2024-06-01T11:00:00+02:00");
  const std::string fiji = Add({179.9, -18.0, 180.1, -17.9}, "2025-01-01T00:00:00Z", "2025-01-01T01:00:00Z");
  const std::string oslo = Add({10.70, 59.90, 10.80, 59.95});  // known from nothing when it was flown
  EXPECT_EQ(Found(Search("")), (Ids{bern, fiji, oslo}));
  EXPECT_EQ(Found(Search("?bbox=7.45,46.92,8,47")), Ids{bern});
  EXPECT_EQ(Found(Search("?bbox=7.45,46.92,0,8,47,100")), Ids{bern});
  EXPECT_EQ(Found(Search("?bbox=179,-19,-179,-17")), Ids{fiji});
  EXPECT_EQ(Found(Search("?bbox=-180,-19,-179.95,-17")), Ids{fiji});
  EXPECT_EQ(Found(Search("?bbox=0,0,1,1")), Ids{});
  EXPECT_EQ(Found(Search("?datetime=2024-06-01T08:30:00Z")), Ids{bern});
  EXPECT_EQ(Found(Search("?datetime=2024-06-01T09:00:00.5Z")), Ids{});
  EXPECT_EQ(Found(Search("?datetime=2024-12-31T00:00:00Z/2025-12-31T00:00:00Z")), Ids{fiji});
  EXPECT_EQ(Found(Search("?datetime=2026-01-01T00:00:00Z/..")), Ids{oslo});  // by when it was made
  EXPECT_EQ(Found(Search("?datetime=../2024-12-31T00:00:00Z")), Ids{bern});
  EXPECT_EQ(Found(Search("?ids=" + oslo + "," + bern + "-r1")), (Ids{bern, oslo}));
  EXPECT_EQ(Found(Search("?ids=" + bern + "-r2")), Ids{});
  EXPECT_EQ(Found(Search("?collections=flights")), (Ids{bern, fiji, oslo}));
  EXPECT_EQ(Found(Search("?collections=others")), Ids{});
  const json corner = {
      {"type", "Polygon"},
      {"coordinates", json::parse("[[[7.39,46.89],[7.42,46.89],[7.39,46.92],[7.39,46.89]]]")}};
  EXPECT_EQ(Posted({{"intersects", corner}}), Ids{bern});
  const json beside = {{"type", "Polygon"},
                       {"coordinates", json::parse("[[[7.3,46.89],[7.45,46.89],[7.3,46.905],[7.3,46.89]]]")}};
  EXPECT_EQ(Posted({{"intersects", beside}}), Ids{});  // whose box meets it, but not itself
  const json through = {{"type", "LineString"}, {"coordinates", {{7.0, 46.0}, {11.0, 61.0}}}};
  EXPECT_EQ(Posted({{"intersects", through}}), Ids{oslo});
  const json both = {{"type", "GeometryCollection"},
                     {"geometries", {{{"type", "Point"}, {"coordinates", {-179.95, -17.95}}}, corner}}};
  EXPECT_EQ(Posted({{"intersects", both}}), (Ids{bern, fiji}));
  EXPECT_EQ(Posted({{"bbox", {7, 46, 8, 47}}, {"ids", {bern, oslo}}, {"limit", 5}}), Ids{bern});
}

TEST_F(StacTest, PagesLeadToTheLast) {
  Ids all;
  for (int i = 0; i < 5; ++i) all.insert(Add({1.0 + i, 1.0, 2.0 + i, 2.0}));
  Ids found;
  std::string next = "/stac/search?limit=2&bbox=0%2C0,20,20";
  int pages = 0;
  for (; !next.empty(); ++pages) {
    const Response response = sample_.Get(next);
    ASSERT_EQ(response.status, 200) << next;
    const json page = json::parse(response.body);
    EXPECT_EQ(page["features"].size(), page["numberReturned"]);
    found.merge(Found(page));
    next = LinkOf(page, "next");
  }
  EXPECT_EQ(found, all);
  EXPECT_EQ(pages, 3);
  const json first = json::parse(Post(R"({"limit":4,"bbox":[0,0,20,20]})").body);
  const json link = *std::find_if(first["links"].begin(), first["links"].end(),
                                  [](const json& one) { return one["rel"] == "next"; });
  EXPECT_EQ(link["method"], "POST");
  EXPECT_EQ(link["body"]["limit"], 4);
  EXPECT_EQ(Posted(link["body"]).size(), 1u);
}

TEST_F(StacTest, DocumentsLeadToEachOther) {
  const std::string flight = Add({1, 1, 2, 2}, "2024-06-01T10:00:00Z", "2024-06-01T11:00:00Z");
  Add({3, 0, 4, 2});
  const json root = json::parse(sample_.Get("/stac").body);
  EXPECT_EQ(root["type"], "Catalog");
  for (const json& link : root["links"]) {
    const std::string path = link["href"].get<std::string>().substr(std::string("http://127.0.0.1:1").size());
    if (path != "/docs") {
      EXPECT_EQ(sample_.Get(path).status, 200) << path;
    }
  }
  const json collection = json::parse(sample_.Get(LinkOf(root, "child")).body);
  EXPECT_EQ(collection["extent"]["spatial"]["bbox"], json::parse("[[1.0,0.0,4.0,2.0]]"));
  EXPECT_EQ(collection["extent"]["temporal"]["interval"][0][0], "2024-06-01T10:00:00Z");
  const json items =
      json::parse(sample_.Get(LinkOf(collection, "items") + "?datetime=2024-06-01T10:30:00Z").body);
  ASSERT_EQ(items["features"].size(), 1u);
  const json item = json::parse(sample_.Get(LinkOf(items["features"][0], "self")).body);
  EXPECT_EQ(item, items["features"][0]);
  EXPECT_EQ(item, json::parse(sample_.Get("/stac/" + flight).body));
  EXPECT_EQ(item["properties"]["start_datetime"], "2024-06-01T10:00:00Z");
  EXPECT_EQ(sample_.Get("/stac/collections/flights/items/" + flight + "-r7").status, 404);
  EXPECT_EQ(sample_.Get("/stac/collections/flights/items/..x").status, 404);
}

// As web-map-links has it: the type of a WMTS or WMS link is the format of its pictures, not of the document.
TEST_F(StacTest, LinksToServicesNameAFormatThatTheyHave) {
  const std::string flight = Add({1, 1, 2, 2});
  const json item = json::parse(sample_.Get("/stac/" + flight).body);
  for (const json& link : item["links"]) {
    if (link["rel"] != "wms" && link["rel"] != "wmts") continue;
    const std::string path = link["href"].get<std::string>().substr(std::string("http://127.0.0.1:1").size());
    const std::string capabilities = sample_.Get(path).body;
    EXPECT_NE(capabilities.find("<Format>" + link["type"].get<std::string>() + "</Format>"),
              std::string::npos)
        << capabilities;
  }
}

TEST_F(StacTest, MapsThatLieNowhereAreNotFound) {
  Add({-0.001, -0.001, 0.001, 0.001});
  const std::string bern = Add({7.40, 46.90, 7.50, 46.95});
  EXPECT_EQ(Found(Search("")), Ids{bern});
  const json collection = json::parse(sample_.Get("/stac/collections/flights").body);
  EXPECT_EQ(collection["extent"]["spatial"]["bbox"], json::parse("[[7.4,46.9,7.5,46.95]]"));
}

TEST_F(StacTest, AcrossTheAntimeridianBoxesAreThoseOfGeoJson) {
  const std::string flight = Add({179.75, -18.0, 180.25, -17.5});
  const json item = Search("")["features"][0];
  EXPECT_EQ(item["bbox"], json::parse("[179.75,-18.0,-179.75,-17.5]"));
  EXPECT_EQ(item["geometry"]["type"], "MultiPolygon");
  const json& sides = item["geometry"]["coordinates"];
  ASSERT_EQ(sides.size(), 2u);
  EXPECT_EQ(sides[0][0][2], json::parse("[180.0,-17.5]"));
  EXPECT_EQ(sides[1][0][2], json::parse("[-179.75,-17.5]"));
  const std::string ogc = "/ogc/collections/" + flight;
  EXPECT_EQ(json::parse(sample_.Get(ogc).body)["extent"]["spatial"]["bbox"],
            json::parse("[[179.75,-18.0,-179.75,-17.5]]"));
  // Blank, as what a map has nothing of is, at both of its sides.
  for (const char* tile : {"/2/3/2.png", "/2/0/2.png"})
    EXPECT_EQ(sample_.Get("/tiles/" + flight + tile).status, 200) << tile;
  EXPECT_EQ(sample_.Get("/tiles/" + flight + "/2/2/2.png").status, 404);
  // A list of limits has one span of columns, and the tiles lie at both ends.
  for (const char* set : {"/map/tiles/WebMercatorQuad", "/map/tiles/WorldCRS84Quad"}) {
    const json limits = json::parse(sample_.Get(ogc + set).body)["tileMatrixSetLimits"];
    ASSERT_FALSE(limits.empty()) << set;
    EXPECT_EQ(limits[0]["minTileCol"], 0) << set;
    EXPECT_GT(limits[0]["maxTileCol"].get<int>(), 0) << set;
  }
  Add({-179.5, -18.0, -179.25, -17.5});  // from there eastward to the end of the other
  const json collection = json::parse(sample_.Get("/stac/collections/flights").body);
  EXPECT_EQ(collection["extent"]["spatial"]["bbox"], json::parse("[[-179.5,-18.0,-179.75,-17.5]]"));
}

TEST_F(StacTest, RefusesWhatCannotBeMeant) {
  Add({1, 1, 2, 2});
  for (const char* box : {"1,2,3", "1,2,3,x", "nan,0,1,1", "0,0,1e9,1", "0,5,1,4", "inf,0,1,1", ""})
    EXPECT_EQ(sample_.Get(std::string("/stac/search?bbox=") + box).status, 400) << box;
  for (const char* query :
       {"limit=-1", "limit=0", "limit=x", "limit=99999999999999999999", "cursor=x", "datetime=yesterday",
        "datetime=2024-06-02T00:00:00Z/2024-06-01T00:00:00Z", "datetime=../..", "datetime=/",
        "intersects=%7B%7D", "intersects=x", "query=%7B%7D", "filter=a%3D1",
        "bbox=0,0,1,1&intersects=%7B%22type%22:%22Point%22,%22coordinates%22:%5B1,1%5D%7D"}) {
    EXPECT_EQ(sample_.Get(std::string("/stac/search?") + query).status, 400) << query;
  }
  for (const char* body :
       {"", "[]", "x", R"({"bbox":[1,2,3]})", R"({"bbox":["a",2,3,4]})", R"({"limit":"x"})",
        R"({"limit":-1})", R"({"limit":1.5})", R"({"datetime":7})", R"({"ids":"a"})", R"({"ids":[1]})",
        R"({"intersects":7})", R"({"intersects":{"type":"Point","coordinates":[]}})",
        R"({"intersects":{"type":"Sphere","coordinates":[1,1]}})",
        R"({"intersects":{"type":"Polygon","coordinates":[[[0,0],[1,1]]]}})",
        R"({"intersects":{"type":"Point","coordinates":[1e300,1]}})", R"({"query":{}})",
        R"({"filter":"a=1"})"}) {
    EXPECT_EQ(Post(body).status, 400) << body;
  }
  std::string deep = R"({"type":"Point","coordinates":[1,1]})";
  for (int i = 0; i < 20; ++i) deep = R"({"type":"GeometryCollection","geometries":[)" + deep + "]}";
  EXPECT_EQ(Post(R"({"intersects":)" + deep + "}").status, 400);
  EXPECT_EQ(sample_.Get("/stac/search?limit=100000").status, 200);  // as many as there may be
}

TEST_F(StacTest, ATokenOfOneFlightFindsThatOne) {
  const std::string shared = Add({1, 1, 2, 2});
  Add({3, 3, 4, 4});
  const Headers share = sample_.MakeToken("shared", storage::Scope::kRead, {}, shared);
  EXPECT_EQ(Found(Search("", share)), Ids{shared});
  EXPECT_EQ(Found(Search("?bbox=3,3,4,4", share)), Ids{});
  const json collection = json::parse(sample_.Get("/stac/collections/flights", share).body);
  EXPECT_EQ(collection["extent"]["spatial"]["bbox"], json::parse("[[1.0,1.0,2.0,2.0]]"));
  EXPECT_EQ(sample_.Get("/stac/search").status, 401);
}

}  // namespace
}  // namespace skyquilt::api
