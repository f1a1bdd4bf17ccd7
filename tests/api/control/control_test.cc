// The control points of a flight: what is kept, what is refused, and that nobody overwrites what another
// changed.
#include <gmock/gmock.h>

#include "api/control/control_list.h"
#include "api/uploads/flight_document.h"
#include "core/base/try.h"
#include "core/pipeline/placing/control_points.h"
#include "tests/api/sample_service.h"

namespace skyquilt::api {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

Result<std::string> ReadHere(const std::filesystem::path& path) {
  SKYQUILT_TRY_ASSIGN(const flight::GcpList list, flight::ReadGcpList({"gcp_list.txt", path}));
  return pipeline::ControlJson(list);
}

class Control : public ::testing::Test {
 protected:
  Control() : flight_(server_.NewFlight()) { server_.service().read_control = ReadHere; }

  std::string Address() const { return "/api/v1/flights/" + flight_ + "/control"; }
  Response Put(const json& body, const std::string& if_match = "") {
    Headers headers{{"Content-Type", "application/json"}};
    if (!if_match.empty()) headers.Add("If-Match", if_match);
    return server_.Send(Method::kPut, Address(), body.dump(), std::move(headers));
  }
  static json Example() {
    return {{"reference_system", "EPSG:32611"},
            {"points",
             {{{"name", "shed corner"},
               {"x", 340000.123},
               {"y", 3810000.5},
               {"height", 12.25},
               {"marks",
                {{{"photo", "DJI 0001.JPG"}, {"x", 100.25}, {"y", 200.0}},
                 {{"photo", "b.jpg"}, {"x", 0.0}, {"y", 7.0}}}}},
              {{"name", "2"},
               {"x", 340050.0},
               {"y", 3810000.5},
               {"height", nullptr},
               {"marks", json::array()}}}}};
  }

  SampleService server_;
  std::string flight_;
};

TEST_F(Control, AreNoneAtFirstAndComeBackAsTheyWereKept) {
  Response none = server_.Get(Address());
  EXPECT_EQ(none.status, 200);
  EXPECT_EQ(none.headers.Find("ETag"), "\"none\"");
  EXPECT_TRUE(json::parse(BodyOf(none))["points"].empty());

  Response kept = Put(Example(), "\"none\"");
  ASSERT_EQ(kept.status, 200) << BodyOf(kept);
  Response got = server_.Get(Address());
  EXPECT_EQ(got.headers.Find("ETag"), kept.headers.Find("ETag"));
  const json document = json::parse(BodyOf(got));
  EXPECT_EQ(document["reference_system"], "EPSG:32611");
  const json& first = document["points"][0];
  EXPECT_EQ(first["name"], "shed corner");
  EXPECT_EQ(first["x"], 340000.123);
  EXPECT_EQ(first["height"], 12.25);
  EXPECT_NEAR(first["lat"].get<double>(), 34.4, 0.1);
  EXPECT_EQ(first["marks"], Example()["points"][0]["marks"]);
  EXPECT_TRUE(document["points"][1]["height"].is_null());
  EXPECT_TRUE(document["points"][1]["marks"].empty());
  // The stitcher finds it among the flight's files, and what came can be sent back.
  const auto files = server_.catalogue.ListFiles(flight_);
  ASSERT_EQ(files->size(), 1u);
  EXPECT_EQ(files->front().name, "gcp_list.txt");
  Response again = Put(document, std::string(got.headers.Find("ETag")));
  EXPECT_EQ(again.status, 200);
  EXPECT_EQ(server_.catalogue.ListFiles(flight_)->size(), 1u);
}

TEST_F(Control, OfAListThatWasUploadedAreShownAndChangedInItsPlace) {
  ASSERT_EQ(server_
                .Send(Method::kPut, "/api/v1/flights/" + flight_ + "/files/GCP_list.txt",
                      "EPSG:4326\n7.1 46.8 500 100.5 200.5 A.JPG north\n")
                .status,
            201);
  Response got = server_.Get(Address());
  json document = json::parse(BodyOf(got));
  EXPECT_EQ(document["points"][0]["marks"][0]["x"], 100.0) << "from the middle of the first pixel";
  document["points"][0]["name"] = "south";
  EXPECT_EQ(Put(document).status, 200);
  ASSERT_EQ(server_.catalogue.ListFiles(flight_)->size(), 1u);
  EXPECT_EQ(server_.catalogue.ListFiles(flight_)->front().name, "GCP_list.txt");
}

TEST_F(Control, ThatAnotherChangedAreNotOverwritten) {
  Response first = Put(Example());
  const std::string old(first.headers.Find("ETag"));
  ASSERT_EQ(Put(Example(), old).status, 200);
  Response late = Put(Example(), old);
  EXPECT_EQ(late.status, 412) << BodyOf(late);
  EXPECT_EQ(Put(Example(), "\"none\"").status, 412);
  EXPECT_EQ(Put({{"points", json::array()}}, old).status, 412);
}

TEST_F(Control, ThatAnotherChangesJustBeforeTheyAreRemovedStay) {
  ASSERT_EQ(Put(Example()).status, 200);
  const auto found = test::ValueOf(FindDocument(server_.service(), flight_, "gcp_list.txt"));
  ASSERT_TRUE(found.has_value());
  ASSERT_EQ(Put(Example()).status, 200);
  const auto removed = RemoveDocument(server_.service(), flight_, found, WantedDocument{found->stored_name});
  EXPECT_EQ(test::ErrorOf(removed).code, ErrorCode::kPreconditionFailed);
  EXPECT_EQ(server_.Json(Address())["points"].size(), 2u);
}

TEST_F(Control, ThatAreAllRemovedLeaveNoFile) {
  ASSERT_EQ(Put(Example()).status, 200);
  Response cleared = Put({{"points", json::array()}});
  EXPECT_EQ(cleared.status, 200);
  EXPECT_EQ(cleared.headers.Find("ETag"), "\"none\"");
  EXPECT_TRUE(server_.catalogue.ListFiles(flight_)->empty());
}

TEST_F(Control, AreRefusedInWordsWhereTheyBreakARule) {
  const auto refusal = [&](const json& change) {
    json document = Example();
    document.merge_patch(change);
    Response response = Put(document);
    EXPECT_EQ(response.status, 422) << change;
    EXPECT_TRUE(server_.catalogue.ListFiles(flight_)->empty()) << change;
    return BodyOf(response);
  };
  const auto with = [](json point) { return json{{"points", {std::move(point)}}}; };
  EXPECT_THAT(refusal({{"reference_system", "no such system"}}), HasSubstr("not known"));
  EXPECT_THAT(refusal({{"reference_system", "EPSG:4326\n1 2 3 4 5 a"}}), HasSubstr("one line"));
  EXPECT_THAT(refusal(with({{"name", ""}, {"x", 1}, {"y", 2}})), HasSubstr("name"));
  EXPECT_THAT(refusal(with({{"name", "a\tb"}, {"x", 1}, {"y", 2}})), HasSubstr("name"));
  EXPECT_THAT(refusal(with({{"name", "a"}, {"x", "1"}, {"y", 2}})), HasSubstr("must be a number"));
  EXPECT_THAT(refusal(with({{"name", "a"}, {"x", 1e300}, {"y", 2}})), HasSubstr("out of range"));
  EXPECT_THAT(refusal(with({{"name", "a"}, {"x", 9e8}, {"y", 9e8}})), HasSubstr("None of the points"));
  json twice = Example();
  twice["points"][1]["name"] = "shed corner";
  EXPECT_THAT(refusal(twice), HasSubstr("two points called"));
  json same = Example();
  same["points"][1] = same["points"][0];
  same["points"][1]["name"] = "other";
  EXPECT_THAT(refusal(same), HasSubstr("same coordinates"));
  json photos = Example();
  photos["points"][0]["marks"][1]["photo"] = "DJI 0001.JPG";
  EXPECT_THAT(refusal(photos), HasSubstr("two marks"));
  EXPECT_THAT(refusal({{"colour", "red"}}), HasSubstr("not known"));
}

TEST_F(Control, ListTextIsBounded) {
  EXPECT_FALSE(ControlListText("{").ok());
  EXPECT_FALSE(ControlListText("[]").ok());
  EXPECT_FALSE(ControlListText(std::string(kMaxControlBytes + 1, ' ')).ok());
  EXPECT_FALSE(ControlListText(std::string(100, '[')).ok());
  json many = {{"points", json::array()}};
  for (std::size_t i = 0; i <= kMaxControlPoints; ++i)
    many["points"].push_back({{"name", std::to_string(i)}, {"x", i}, {"y", i}});
  EXPECT_THAT(ControlListText(many.dump()).error().message, HasSubstr("more than 2000 points"));
}

TEST_F(Control, ThatAreReplacedWhileTheyAreReadAreReadAnew) {
  ASSERT_EQ(Put(Example()).status, 200);
  json changed = Example();
  changed["points"].erase(1);
  bool is_replaced = false;
  server_.service().read_control = [&](const std::filesystem::path& path) {
    if (!std::exchange(is_replaced, true)) {
      EXPECT_EQ(Put(changed).status, 200);
      EXPECT_FALSE(std::filesystem::exists(path));
    }
    return ReadHere(path);
  };
  Response got = server_.Get(Address());
  ASSERT_EQ(got.status, 200) << BodyOf(got);
  EXPECT_EQ(json::parse(BodyOf(got))["points"].size(), 1u);
  EXPECT_EQ(Put(changed, std::string(got.headers.Find("ETag"))).status, 200);
}

TEST_F(Control, AreChangedByWhoMayUploadAndReadByWhoMayRead) {
  const Headers reader = server_.MakeToken("reader", storage::Scope::kRead);
  EXPECT_EQ(server_.Get(Address(), reader).status, 200);
  Headers headers = reader;
  headers.Add("Content-Type", "application/json");
  EXPECT_EQ(server_.Send(Method::kPut, Address(), Example().dump(), headers).status, 403);
}

}  // namespace
}  // namespace skyquilt::api
