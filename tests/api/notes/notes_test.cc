// The notes of a flight: what is kept, what is refused, and that nobody's are lost.
#include <gmock/gmock.h>

#include "api/notes/note_list.h"
#include "tests/api/sample_service.h"

namespace skyquilt::api {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

json NoteAt(const std::string& id, const json& geometry, const std::string& name = "Well") {
  return {{"type", "Feature"}, {"id", id}, {"geometry", geometry}, {"properties", {{"name", name}}}};
}

json PointAt(double lon_deg, double lat_deg) {
  return {{"type", "Point"}, {"coordinates", {lon_deg, lat_deg}}};
}

json Collected(const json& features) { return {{"type", "FeatureCollection"}, {"features", features}}; }

json ExampleNotes() {
  json note = NoteAt("n-1", PointAt(7.4391234567, 46.95));
  note["properties"]["text"] = "Cover is loose.\nTold to M\u00fcller.";
  const json line = {{"type", "LineString"},
                     {"coordinates", json::parse("[[7.4,46.9],[7.41,46.9],[7.41,46.95]]")}};
  const json ring = json::parse("[[7.4,46.9],[7.41,46.9],[7.41,46.95],[7.4,46.9]]");
  const json area = {{"type", "Polygon"}, {"coordinates", json::array({ring})}};
  return Collected(json::array({note, NoteAt("n-2", line, "Fence"), NoteAt("N_3", area, "Pond")}));
}

class Notes : public ::testing::Test {
 protected:
  Notes() : flight_(server_.NewFlight()) {}

  std::string Address() const { return "/api/v1/flights/" + flight_ + "/notes"; }
  Response PutText(const std::string& body, const std::string& if_match = "", Headers headers = {}) {
    headers.Add("Content-Type", "application/geo+json");
    if (!if_match.empty()) headers.Add("If-Match", if_match);
    return server_.Send(Method::kPut, Address(), body, std::move(headers));
  }
  Response Put(const json& body, const std::string& if_match = "") { return PutText(body.dump(), if_match); }

  SampleService server_;
  std::string flight_;
};

TEST_F(Notes, AreNoneAtFirstAndComeBackAsTheyWereKept) {
  const Response none = server_.Get(Address());
  EXPECT_EQ(none.status, 200);
  EXPECT_EQ(none.headers.Find("ETag"), "\"none\"");
  EXPECT_EQ(none.headers.Find("Content-Type"), "application/geo+json");
  EXPECT_EQ(json::parse(none.body), Collected(json::array()));

  const Response kept = Put(ExampleNotes(), "\"none\"");
  ASSERT_EQ(kept.status, 200) << kept.body;
  const Response got = server_.Get(Address());
  EXPECT_EQ(got.headers.Find("ETag"), kept.headers.Find("ETag"));
  EXPECT_EQ(json::parse(got.body), ExampleNotes());
  const auto files = server_.catalogue.ListFiles(flight_);
  ASSERT_EQ(files->size(), 1u);
  EXPECT_EQ(files->front().name, "map_notes.geojson");
  EXPECT_EQ(Put(json::parse(got.body), std::string(got.headers.Find("ETag"))).status, 200);
  EXPECT_EQ(server_.catalogue.ListFiles(flight_)->size(), 1u);
}

TEST_F(Notes, ThatAnotherChangedAreNotOverwritten) {
  const std::string old(Put(ExampleNotes()).headers.Find("ETag"));
  ASSERT_EQ(Put(Collected(json::array({NoteAt("b", PointAt(1, 2))})), old).status, 200);
  const Response late = Put(ExampleNotes(), old);
  EXPECT_EQ(late.status, 412);
  EXPECT_THAT(late.body, HasSubstr("changed elsewhere"));
  EXPECT_EQ(Put(ExampleNotes(), "\"none\"").status, 412);
  EXPECT_EQ(json::parse(server_.Get(Address()).body)["features"][0]["id"], "b");
}

TEST_F(Notes, AreNeverReplacedByWhoDoesNotSayWhatHeReplaces) {
  const std::string tag(Put(ExampleNotes()).headers.Find("ETag"));
  for (const json& body : {Collected(json::array()), Collected(json::array({NoteAt("b", PointAt(1, 2))}))}) {
    const Response refused = Put(body);
    EXPECT_EQ(refused.status, 412);
    EXPECT_THAT(refused.body, HasSubstr("If-Match"));
  }
  EXPECT_EQ(json::parse(server_.Get(Address()).body), ExampleNotes());
  EXPECT_EQ(Put(Collected(json::array()), tag).status, 200);
  EXPECT_TRUE(json::parse(server_.Get(Address()).body)["features"].empty());
  // Where none are, none can be lost.
  EXPECT_EQ(Put(ExampleNotes()).status, 200);
}

TEST_F(Notes, AreRefusedInWordsWhereTheyBreakARule) {
  const auto refusal = [&](const json& document, int status = 422) {
    const Response response = Put(document);
    EXPECT_EQ(response.status, status) << document;
    EXPECT_TRUE(server_.catalogue.ListFiles(flight_)->empty()) << document;
    return response.body;
  };
  const auto with = [](const json& change) {
    json note = NoteAt("a", PointAt(1, 2));
    note.merge_patch(change);
    return Collected(json::array({note}));
  };
  const auto shaped = [](const char* type, const json& coordinates) {
    return Collected(json::array({NoteAt("a", {{"type", type}, {"coordinates", coordinates}})}));
  };
  EXPECT_THAT(refusal(json::array()), HasSubstr("FeatureCollection"));
  EXPECT_THAT(refusal({{"type", "FeatureCollection"}}), HasSubstr("must be a list"));
  EXPECT_THAT(refusal({{"type", "FeatureCollection"}, {"features", json::array()}, {"crs", 1}}),
              HasSubstr("not known"));
  EXPECT_THAT(refusal(Collected(json::array({1}))), HasSubstr("GeoJSON Feature"));
  EXPECT_THAT(refusal(with({{"id", nullptr}})), HasSubstr("needs an"));
  EXPECT_THAT(refusal(with({{"id", "a b"}})), HasSubstr("needs an"));
  EXPECT_THAT(refusal(with({{"id", std::string(65, 'a')}})), HasSubstr("needs an"));
  EXPECT_THAT(refusal(Collected(json::array({NoteAt("a", PointAt(1, 2)), NoteAt("a", PointAt(3, 4))}))),
              HasSubstr("two notes"));
  EXPECT_THAT(refusal(with({{"colour", "red"}})), HasSubstr("not known"));
  EXPECT_THAT(refusal(with({{"properties", {{"stroke", "red"}}}})), HasSubstr("not known"));
  EXPECT_THAT(refusal(with({{"properties", {{"name", ""}}}})), HasSubstr("one line"));
  EXPECT_THAT(refusal(with({{"properties", {{"name", "a\nb"}}}})), HasSubstr("one line"));
  EXPECT_THAT(refusal(with({{"properties", {{"name", std::string(201, 'x')}}}})), HasSubstr("one line"));
  EXPECT_THAT(refusal(with({{"properties", {{"text", 3}}}})), HasSubstr("must be text"));
  EXPECT_THAT(refusal(with({{"properties", {{"text", std::string("a\0b", 3)}}}})), HasSubstr("must be text"));
  EXPECT_THAT(refusal(with({{"properties", {{"text", std::string(4001, 'x')}}}})), HasSubstr("must be text"));
  EXPECT_THAT(refusal(with({{"geometry", nullptr}})), HasSubstr("needs a geometry"));
  EXPECT_THAT(refusal(shaped("MultiPoint", {{1, 2}})), HasSubstr("must be a Point"));
  EXPECT_THAT(refusal(shaped("Point", {1, 2, 3})), HasSubstr("two numbers"));
  EXPECT_THAT(refusal(shaped("Point", {"1", 2})), HasSubstr("two numbers"));
  EXPECT_THAT(refusal(shaped("Point", {1, 91})), HasSubstr("not on Earth"));
  EXPECT_THAT(refusal(shaped("LineString", json::array({json::array({1, 2})}))), HasSubstr("at least 2"));
  EXPECT_THAT(refusal(shaped("Polygon", json::parse("[[[1,2],[3,4],[1,2]]]"))), HasSubstr("at least 4"));
  EXPECT_THAT(refusal(shaped("Polygon", json::parse("[[[1,2],[3,4],[5,6],[7,8]]]"))),
              HasSubstr("end where it begins"));
  EXPECT_THAT(refusal(shaped("Polygon", json::array())), HasSubstr("one ring"));
}

TEST_F(Notes, ThatAreNoTextOfNotesAreRefusedBeforeTheyAreRead) {
  EXPECT_EQ(PutText("").status, 400);
  EXPECT_EQ(PutText("{").status, 400);
  EXPECT_EQ(PutText("{\"type\":\"\xFF\"}").status, 400);
  EXPECT_EQ(PutText(std::string(100, '[')).status, 400);
  EXPECT_THAT(ReadNotes(R"({"type":"FeatureCollection","features":[{"type":"Feature","id":"a",)"
                        R"("geometry":{"type":"Point","coordinates":[1e999,2]},"properties":{"name":"x"}}]})")
                  .error()
                  .message,
              ::testing::Not(::testing::IsEmpty()));
  EXPECT_EQ(ReadNotes(std::string(kMaxNotesBytes + 1, ' ')).error().code, ErrorCode::kTooLarge);
  // Each member is looked for among those before it: of a hundred thousand that takes half a minute.
  std::string members = R"({"type": "FeatureCollection", "features": [], "0": 0)";
  while (members.size() + 20 < kMaxNotesBytes) members += ", \"" + std::to_string(members.size()) + "\": 0";
  EXPECT_THAT(ReadNotes(members + "}").error().message, HasSubstr("more than 1000 members"));
  json many = json::array();
  for (std::size_t i = 0; i <= kMaxNotes; ++i) many.push_back(NoteAt(std::to_string(i), PointAt(1, 2)));
  EXPECT_THAT(ReadNotes(Collected(many).dump()).error().message, HasSubstr("more than 2000 notes"));
  // Short as they come, long as they would be kept.
  std::string positions;
  for (int i = 0; i < 170'000; ++i) positions += positions.empty() ? "[0,0]" : ",[0,0]";
  EXPECT_EQ(ReadNotes(R"({"type":"FeatureCollection","features":[{"type":"Feature","id":"a","geometry":)"
                      R"({"type":"LineString","coordinates":[)" +
                      positions + R"(]},"properties":{"name":"x"}}]})")
                .error()
                .code,
            ErrorCode::kTooLarge);
  EXPECT_EQ(
      server_.Send(Method::kPut, Address(), ExampleNotes().dump(), {{"Content-Type", "text/plain"}}).status,
      415);
}

TEST_F(Notes, InAFileThatAUserSentAreReadAsStrictly) {
  const auto send = [&](const std::string& text) {
    return server_
        .Send(Method::kPut, "/api/v1/flights/" + flight_ + "/files/Map_Notes.geojson", text,
              {{"If-Match", "*"}})
        .status;
  };
  ASSERT_EQ(send(ExampleNotes().dump()), 201);
  EXPECT_EQ(json::parse(server_.Get(Address()).body), ExampleNotes());
  ASSERT_EQ(send("no notes"), 200);
  const Response broken = server_.Get(Address());
  EXPECT_EQ(broken.status, 422);
  EXPECT_THAT(broken.body, HasSubstr("Map_Notes.geojson"));
  EXPECT_EQ(Put(ExampleNotes()).status, 412) << "what cannot be read is not overwritten either";
}

TEST_F(Notes, AreChangedByWhoMayUploadAndReadByWhoMayRead) {
  const Headers reader = server_.MakeToken("reader", storage::Scope::kRead);
  const Headers guest = server_.MakeToken("guest", storage::Scope::kRead, {}, flight_);
  const Headers stranger = server_.MakeToken("stranger", storage::Scope::kRead, {}, server_.NewFlight());
  const Headers writer = server_.MakeToken("writer", storage::Scope::kAdmin);
  EXPECT_EQ(PutText(ExampleNotes().dump(), "", reader).status, 403);
  EXPECT_EQ(PutText(ExampleNotes().dump(), "", guest).status, 403);
  EXPECT_EQ(PutText(ExampleNotes().dump(), "", writer).status, 200);
  EXPECT_EQ(server_.Get(Address(), reader).status, 200);
  EXPECT_EQ(json::parse(server_.Get(Address(), guest).body), ExampleNotes());
  EXPECT_EQ(server_.Get(Address(), stranger).status, 404);
  EXPECT_EQ(server_.Get(Address()).status, 401);
}

TEST_F(Notes, OfAFlightThatThereIsNotAreNotThere) {
  EXPECT_EQ(server_.Get("/api/v1/flights/01jzzzzzzzzzzzzzzzzzzzzzzz/notes").status, 404);
  EXPECT_EQ(server_.Get("/api/v1/flights/nonsense/notes").status, 404);
}

}  // namespace
}  // namespace skyquilt::api
