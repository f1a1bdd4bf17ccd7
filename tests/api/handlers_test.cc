// The API's routes over a real data folder, without a socket.
#include <algorithm>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "api/flights/trash.h"
#include "storage/db/ids.h"
#include "tests/api/sample_service.h"
#include "tests/storage/blobs/far_folder.h"

namespace skyquilt::api {
namespace {

using nlohmann::json;

json JsonOf(const Response& response) { return json::parse(response.body); }

Headers Typed(const std::string& type) { return {{"Content-Type", type}}; }

std::string Form(const std::vector<std::pair<std::string, std::string>>& files) {
  std::string body;
  for (const auto& [name, bytes] : files) {
    body += "--b\r\nContent-Disposition: form-data; name=\"file\"; filename=\"" + name + "\"\r\n\r\n" +
            bytes + "\r\n";
  }
  return body + "--b--\r\n";
}

const std::string kForm = "multipart/form-data; boundary=b";

int CountIn(const std::filesystem::path& folder) {
  return std::filesystem::exists(folder)
             ? static_cast<int>(std::distance(std::filesystem::directory_iterator(folder), {}))
             : 0;
}

TEST(Flights, AreMadeListedRenamedAndDeleted) {
  SampleService sample;
  const Response made =
      sample.Send(Method::kPost, "/api/v1/flights", R"({"name":"North field"})", Typed("application/json"));
  EXPECT_EQ(made.status, 201);
  const std::string id = JsonOf(made)["id"];
  EXPECT_EQ(made.headers.Find("Location"), "/api/v1/flights/" + id);
  EXPECT_EQ(JsonOf(made)["state"], "empty");
  EXPECT_EQ(JsonOf(sample.Get("/api/v1/flights"))["flights"][0]["name"], "North field");
  const Response renamed =
      sample.Send(Method::kPatch, "/api/v1/flights/" + id, R"({"name":"South"})", Typed("application/json"));
  EXPECT_EQ(JsonOf(renamed)["name"], "South");
  EXPECT_EQ(sample.Send(Method::kDelete, "/api/v1/flights/" + id).status, 204);
  EXPECT_EQ(sample.Get("/api/v1/flights/" + id).status, 404);
  EXPECT_EQ(sample.Send(Method::kDelete, "/api/v1/flights/" + id).status, 404);
  EXPECT_EQ(CountIn(sample.dir().Flights()), 0);
}

TEST(Flights, RemovedForGoodTakeAlongWhatTheirJobHadMade) {
  for (const int trash_days : {0, 30}) {
    SampleService sample;
    sample.service().trash_days = trash_days;
    const std::string flight = sample.NewFlight();
    ASSERT_TRUE(sample.queue.Add(flight, "{}", storage::Now()));
    const storage::Lease lease = **sample.queue.Claim("w", storage::Now());
    std::filesystem::create_directories(sample.dir().Work() / storage::WorkName(lease));
    ASSERT_TRUE(*sample.queue.GiveBack(lease, storage::Now()));  // as after a stop
    EXPECT_EQ(sample.Send(Method::kDelete, "/api/v1/flights/" + flight).status, 204);
    if (trash_days > 0) {
      EXPECT_EQ(sample.Send(Method::kDelete, "/api/v1/trash/" + flight).status, 204);
    }
    EXPECT_EQ(CountIn(sample.dir().Work()), 0) << trash_days;
  }
}

TEST(Flights, StayWhileTheStoreOfPhotosCannotBeToldThatTheyGo) {
  SampleService sample;
  const auto far = std::make_shared<test::FarFolder>(sample.dir().root() / "far");
  storage::PhotoStore store(sample.dir(), far);
  Metrics metrics;
  Service service{sample.catalogue, sample.queue,        store,  sample.service().tilesets,
                  metrics,          sample.service().db, "1.2.3"};
  const std::string flight = sample.NewFlight();
  ASSERT_TRUE(sample.catalogue.AddFile(flight, {"a.jpg", storage::NewId(), 1}, storage::Now()));
  far->puts_left = 0;
  EXPECT_TRUE(RemoveFlight(service, sample.NewFlight()));  // of which nothing is there
  EXPECT_EQ(RemoveFlight(service, flight).error().code, ErrorCode::kUnavailable);
  EXPECT_TRUE(*sample.catalogue.HasFlight(flight));
  far->puts_left = 1;
  EXPECT_EQ(RemoveFlight(service, flight, storage::Time()).error().code, ErrorCode::kNotFound);
  EXPECT_FALSE(far->Find("deleted/" + flight));  // it was restored meanwhile
  EXPECT_TRUE(RemoveFlight(service, flight));
  EXPECT_FALSE(*sample.catalogue.HasFlight(flight));
  EXPECT_TRUE(far->Find("deleted/" + flight));
}

TEST(Flights, RefuseBadParameters) {
  SampleService sample;
  for (const char* query : {"limit=0", "limit=501", "limit=x", "limit=1.5", "cursor=x", "cursor='OR+1=1"}) {
    EXPECT_EQ(sample.Get(std::string("/api/v1/flights?") + query).status, 400) << query;
  }
  EXPECT_EQ(sample.Send(Method::kPost, "/api/v1/flights", "x", Typed("text/csv")).status, 415);
  EXPECT_EQ(sample.Send(Method::kPost, "/api/v1/flights", "{\"a\":1}", Typed("application/json")).status,
            422);
  EXPECT_EQ(sample.Send(Method::kPost, "/api/v1/flights", "{", Typed("application/json")).status, 400);
  EXPECT_EQ(sample.Get("/api/v1/flights/..etc").status, 404);
}

TEST(Files, ArePutReplacedListedAndRemoved) {
  SampleService sample;
  const std::string files = "/api/v1/flights/" + sample.NewFlight() + "/files";
  EXPECT_EQ(sample.Send(Method::kPut, files + "/a%20b.jpg", "one").status, 201);
  EXPECT_EQ(sample.Send(Method::kPut, files + "/a%20b.jpg", "three", {{"If-Match", "*"}}).status, 200);
  const json listed = JsonOf(sample.Get(files));
  ASSERT_EQ(listed["files"].size(), 1u);
  EXPECT_EQ(listed["files"][0], (json{{"name", "a b.jpg"}, {"bytes", 5}}));
  EXPECT_EQ(sample.Send(Method::kDelete, files + "/a%20b.jpg").status, 204);
  EXPECT_EQ(sample.Send(Method::kDelete, files + "/a%20b.jpg").status, 404);
  EXPECT_EQ(CountIn(sample.dir().Incoming()), 0);
}

TEST(Files, OfAnotherCardTakeNobodysPlace) {
  SampleService sample;
  const std::string flight = sample.NewFlight();
  const std::string at = "/api/v1/flights/" + flight + "/files/DJI_0001.JPG";
  ASSERT_EQ(sample.Send(Method::kPut, at, "first").status, 201);
  const std::string stored = sample.catalogue.FindFile(flight, "DJI_0001.JPG")->value().stored_name;
  for (const bool says_length : {true, false}) {
    // Of the same length too: the bytes count.
    for (const char* other : {"other", "longer"}) {
      const Response refused = sample.Send(Method::kPut, at, other, {}, says_length);
      EXPECT_EQ(refused.status, 409);
      const std::string said = JsonOf(refused)["detail"];
      EXPECT_NE(said.find("101MEDIA_DJI_0001.JPG"), std::string::npos) << said;
      EXPECT_NE(said.find("If-Match: *"), std::string::npos) << said;
    }
    // What came twice changes nothing.
    EXPECT_EQ(sample.Send(Method::kPut, at, "first", {}, says_length).status, 200);
  }
  EXPECT_EQ(sample.catalogue.FindFile(flight, "DJI_0001.JPG")->value().stored_name, stored);
  EXPECT_EQ(CountIn(sample.dir().Files(flight)), 1);
  EXPECT_EQ(CountIn(sample.dir().Incoming()), 0);
  EXPECT_EQ(sample.Send(Method::kPut, at + ".txt", "other").status, 201);
}

TEST(Files, AreNeitherPartsNorEncodedBodies) {
  SampleService sample;
  const std::string flight = sample.NewFlight();
  const std::string at = "/api/v1/flights/" + flight + "/files/a.jpg";
  const auto put = [&](const char* name, const char* value) {
    return sample.Send(Method::kPut, at, "bytes", {{name, value}}).status;
  };
  EXPECT_EQ(put("Content-Range", "bytes 0-4/10"), 400);
  EXPECT_EQ(put("Content-Encoding", "gzip"), 415);
  EXPECT_EQ(CountIn(sample.dir().Files(flight)), 0);
  EXPECT_EQ(put("Content-Encoding", "identity"), 201);
}

TEST(Files, OfAnArchiveAreRefusedWhereNoneIsTaken) {
  SampleService sample;
  const std::string at = "/api/v1/flights/" + sample.NewFlight() + "/files/";
  sample.service().unpack = [](const auto&, const auto&, const auto&, std::int64_t) {
    const Error wrong{ErrorCode::kUnprocessable, "No name.", ""};
    return Result<std::vector<storage::UnpackedFile>>({{{"in.jpg", "", 0}, wrong}});
  };
  const Response refused = sample.Send(Method::kPut, at + "a.zip", "bytes");
  EXPECT_EQ(refused.status, 422) << refused.body;
  EXPECT_EQ(JsonOf(refused)["detail"],
            "None of the 1 file in \"a.zip\" was taken. The first, \"in.jpg\": No name.");
}

TEST(Files, WhoseBytesAreLostCanBeReplaced) {
  SampleService sample;
  const std::string flight = sample.NewFlight();
  const std::string at = "/api/v1/flights/" + flight + "/files/DJI_0001.JPG";
  ASSERT_EQ(sample.Send(Method::kPut, at, "first").status, 201);
  const std::string stored = sample.catalogue.FindFile(flight, "DJI_0001.JPG")->value().stored_name;
  std::filesystem::remove(sample.dir().Files(flight) / stored);
  EXPECT_EQ(sample.Send(Method::kPut, at, "again").status, 409);
  EXPECT_EQ(sample.Send(Method::kPut, at, "again", {{"If-Match", "*"}}).status, 200);
  EXPECT_EQ(CountIn(sample.dir().Files(flight)), 1);
}

TEST(Files, AreReplacedByTheirEtag) {
  SampleService sample;
  const std::string flight = sample.NewFlight();
  const std::string at = "/api/v1/flights/" + flight + "/files/geo.txt";
  ASSERT_EQ(sample.Send(Method::kPut, at, "one").status, 201);
  Headers known{{"If-Match", std::string(sample.Get(at).headers.Find("ETag"))}};
  EXPECT_EQ(sample.Send(Method::kPut, at, "two", known).status, 200);
  EXPECT_EQ(sample.Send(Method::kPut, at, "three", known).status, 412) << "it was replaced meanwhile";
  Response got = sample.Get(at);
  EXPECT_EQ(BodyOf(got), "two");
  EXPECT_EQ(CountIn(sample.dir().Files(flight)), 1);
}

TEST(Files, ThatAJobReadsMayComeAgainButNotChange) {
  SampleService sample;
  const std::string flight = sample.NewFlight();
  const std::string at = "/api/v1/flights/" + flight + "/files/a.jpg";
  ASSERT_EQ(sample.Send(Method::kPut, at, "one").status, 201);
  ASSERT_TRUE(sample.queue.Add(flight, "{}", storage::Now()));
  ASSERT_TRUE(sample.queue.Claim("w", storage::Now())->has_value());
  EXPECT_EQ(sample.Send(Method::kPut, at, "one").status, 200);
  EXPECT_EQ(sample.Send(Method::kPut, at, "two", {{"If-Match", "*"}}).status, 409);
  EXPECT_EQ(CountIn(sample.dir().Files(flight)), 1);
}

TEST(Files, RefuseEmptyOnesAndUnknownFlights) {
  SampleService sample;
  const std::string flight = sample.NewFlight();
  EXPECT_EQ(sample.Send(Method::kPut, "/api/v1/flights/" + flight + "/files/a.jpg", "").status, 422);
  EXPECT_EQ(sample.Send(Method::kPut, "/api/v1/flights/00000000000000000000000000/files/a.jpg", "x").status,
            404);
  EXPECT_EQ(sample.Send(Method::kPut, "/api/v1/flights/x/files/a.jpg", "x").status, 404);
  EXPECT_EQ(CountIn(sample.dir().Incoming()), 0);
  EXPECT_EQ(JsonOf(sample.Get("/api/v1/flights/" + flight))["state"], "empty");
}

TEST(Form, MakesAFlightWithItsFilesAndQueuesIt) {
  SampleService sample;
  const std::string body =
      "--b\r\nContent-Disposition: form-data; name=\"name\"\r\n\r\nMy field\r\n"
      "--b\r\nContent-Disposition: form-data; name=\"options\"\r\n\r\n{\"quality\":70}\r\n" +
      Form({{"a.jpg", "one"}, {"a.jpg", "two!"}, {"../b.jpg", "x"}, {"c.jpg", ""}, {"", ""}});
  const Response response = sample.Send(Method::kPost, "/api/v1/flights", body, Typed(kForm));
  ASSERT_EQ(response.status, 202) << response.body;
  const json answer = JsonOf(response);
  EXPECT_EQ(answer["flight"]["name"], "My field");
  EXPECT_EQ(answer["flight"]["state"], "queued");
  EXPECT_EQ(answer["flight"]["file_count"], 2);
  EXPECT_EQ(answer["job"]["state"], "accepted");
  EXPECT_EQ(response.headers.Find("Location"), "/api/v1/jobs/" + answer["job"]["id"].get<std::string>());
  ASSERT_EQ(answer["files"].size(), 4u);
  EXPECT_EQ(answer["files"][0]["name"], "a.jpg");
  EXPECT_EQ(answer["files"][1]["name"], "a(2).jpg");
  EXPECT_TRUE(answer["files"][1].contains("note"));
  EXPECT_TRUE(answer["files"][2].contains("error"));
  EXPECT_TRUE(answer["files"][3].contains("error"));
  EXPECT_EQ(CountIn(sample.dir().Incoming()), 0);
  const auto lease = sample.queue.Claim("w", storage::Now());
  EXPECT_EQ((*lease)->options, "{\"quality\":70}");
}

TEST(Form, LeavesNothingBehindWhenItCannotBeTaken) {
  SampleService sample;
  const auto status = [&](const std::string& body) {
    return sample.Send(Method::kPost, "/api/v1/flights", body, Typed(kForm)).status;
  };
  EXPECT_EQ(status(Form({})), 422);
  EXPECT_EQ(status(Form({{"a.jpg", ""}})), 422);
  EXPECT_EQ(status(Form({{"../../a.jpg", "x"}})), 422);
  EXPECT_EQ(status(Form({{"a.jpg", "x"}}).substr(0, 60)), 400);
  const std::string bad_options =
      "--b\r\nContent-Disposition: form-data; name=\"options\"\r\n\r\n{\"x\":1}\r\n";
  EXPECT_EQ(status(bad_options + Form({{"a.jpg", "x"}})), 422);
  const std::string bad_text =
      "--b\r\nContent-Disposition: form-data; name=\"options\"\r\n\r\n1},\"name\":{\r\n";
  EXPECT_EQ(status(bad_text + Form({{"a.jpg", "x"}})), 400);
  EXPECT_LT(status("--b\r\nContent-Disposition: form-data; name=\"zz\"\r\n\r\n1\r\n" + Form({{"a", "x"}})),
            0);
  EXPECT_TRUE(JsonOf(sample.Get("/api/v1/flights"))["flights"].empty());
  EXPECT_EQ(CountIn(sample.dir().Flights()), 0);
  EXPECT_EQ(CountIn(sample.dir().Incoming()), 0);
}

TEST(Form, AddsFilesToAFlight) {
  SampleService sample;
  const std::string files = "/api/v1/flights/" + sample.NewFlight() + "/files";
  const Response response =
      sample.Send(Method::kPost, files, Form({{"a.jpg", "1"}, {"b.jpg", "2"}}), Typed(kForm));
  EXPECT_EQ(response.status, 201);
  EXPECT_EQ(JsonOf(response)["files"].size(), 2u);
  EXPECT_EQ(JsonOf(sample.Get(files))["files"].size(), 2u);
}

TEST(Jobs, AreQueuedShownAndCancelled) {
  SampleService sample;
  const std::string flight = "/api/v1/flights/" + sample.NewFlight();
  EXPECT_EQ(sample.Send(Method::kPost, flight + "/jobs").status, 409);
  sample.Send(Method::kPut, flight + "/files/a.jpg", "x");
  const Response queued =
      sample.Send(Method::kPost, flight + "/jobs", R"({"options":{"gsd_m":0.2}})", Typed("application/json"));
  ASSERT_EQ(queued.status, 202);
  const std::string job = "/api/v1/jobs/" + JsonOf(queued)["id"].get<std::string>();
  EXPECT_EQ(queued.headers.Find("Location"), job);
  EXPECT_EQ(sample.Send(Method::kPost, flight + "/jobs").status, 409);
  EXPECT_EQ(JsonOf(sample.Get(job))["state"], "accepted");
  EXPECT_EQ(JsonOf(sample.Get("/api/v1/jobs"))["jobs"].size(), 1u);
  EXPECT_EQ(JsonOf(sample.Send(Method::kDelete, job))["state"], "dismissed");
  EXPECT_EQ(JsonOf(sample.Get(flight))["state"], "uploaded");
  EXPECT_EQ(sample.Get("/api/v1/jobs/x").status, 404);
  EXPECT_EQ(sample.Send(Method::kPost, "/api/v1/flights/00000000000000000000000000/jobs").status, 404);
}

TEST(Jobs, AreListedPageByPage) {
  SampleService sample;
  std::vector<std::string> ids;
  for (int i = 0; i < 3; ++i)
    ids.push_back(test::ValueOf(sample.queue.Add(sample.NewFlight(), "{}", storage::Now())).id);
  const auto first = JsonOf(sample.Get("/api/v1/jobs?limit=2"));
  ASSERT_EQ(first["jobs"].size(), 2u);
  EXPECT_EQ(first["jobs"][0]["id"], ids[2]);
  EXPECT_EQ(first["next_cursor"], ids[1]);
  const auto rest = JsonOf(sample.Get("/api/v1/jobs?limit=2&cursor=" + ids[1]));
  ASSERT_EQ(rest["jobs"].size(), 1u);
  EXPECT_EQ(rest["jobs"][0]["id"], ids[0]);
  EXPECT_TRUE(rest["next_cursor"].is_null());
  EXPECT_EQ(sample.Get("/api/v1/jobs?limit=0").status, 400);
}

TEST(Downloads, HonourRangesAndTags) {
  SampleService sample;
  const std::string id = sample.NewFlight();
  const std::string tif = "/api/v1/flights/" + id + "/download.tif";
  EXPECT_EQ(sample.Get(tif).status, 404);
  sample.Publish(id, {{1, 0, 0, "x"}});
  Response whole = sample.Get(tif);
  EXPECT_EQ(whole.status, 200);
  EXPECT_EQ(BodyOf(whole), "0123456789");
  const std::string etag(whole.headers.Find("ETag"));
  const auto ranged = [&](const std::string& range, const std::string& if_range = "") {
    Headers headers{{"Range", range}};
    if (!if_range.empty()) headers.Add("If-Range", if_range);
    return sample.Get(tif, headers);
  };
  Response part = ranged("bytes=2-4");
  EXPECT_EQ(part.status, 206);
  EXPECT_EQ(BodyOf(part), "234");
  EXPECT_EQ(part.headers.Find("Content-Range"), "bytes 2-4/10");
  EXPECT_EQ(ranged("bytes=2-4", etag).status, 206);
  EXPECT_EQ(ranged("bytes=2-4", "\"other\"").status, 200);
  const Response beyond = ranged("bytes=10-");
  EXPECT_EQ(beyond.status, 416);
  EXPECT_EQ(beyond.headers.Find("Content-Range"), "bytes */10");
  EXPECT_EQ(sample.Get(tif, {{"If-None-Match", etag}}).status, 304);
  // Browsers that fetch parts side by side: of another file none is to come.
  EXPECT_EQ(sample.Get(tif, {{"Range", "bytes=2-4"}, {"If-Match", etag}}).status, 206);
  EXPECT_EQ(sample.Get(tif, {{"Range", "bytes=2-4"}, {"If-Match", "\"other\""}}).status, 412);
  EXPECT_EQ(sample.Get("/api/v1/flights/" + id + "/report").status, 200);
  EXPECT_EQ(sample.Get("/api/v1/flights/" + id + "/photos.geojson").headers.Find("Content-Type"),
            "application/geo+json");
}

TEST(Flights, ShowTheirMapOnceThereIsOne) {
  SampleService sample;
  const std::string id = sample.NewFlight();
  sample.Publish(id, {{1, 0, 0, "x"}, {2, 0, 0, "y"}});
  const json flight = JsonOf(sample.Get("/api/v1/flights/" + id));
  EXPECT_EQ(flight["state"], "ready");
  EXPECT_EQ(flight["revision"], 1);
  EXPECT_EQ(flight["tilejson"], "/tiles/" + id + ".json");
  EXPECT_EQ(flight["min_zoom"], 1);
  EXPECT_EQ(flight["bounds"].size(), 4u);
}

TEST(IdempotencyKeys, CarryARequestOutOnce) {
  SampleService sample;
  Headers headers = Typed("application/json");
  headers.Add("Idempotency-Key", "k1");
  const Response first = sample.Send(Method::kPost, "/api/v1/flights", R"({"name":"A"})", headers);
  const Response again = sample.Send(Method::kPost, "/api/v1/flights", R"({"name":"A"})", headers);
  EXPECT_EQ(first.status, 201);
  EXPECT_EQ(again.status, 201);
  EXPECT_EQ(again.body, first.body);
  EXPECT_EQ(again.headers.Find("Location"), first.headers.Find("Location"));
  EXPECT_EQ(again.headers.Find("Idempotency-Replayed"), "true");
  EXPECT_EQ(sample.Send(Method::kPost, "/api/v1/flights", R"({"name":"B"})", headers).status, 422);
  EXPECT_EQ(JsonOf(sample.Get("/api/v1/flights"))["flights"].size(), 1u);
  headers.Set("Idempotency-Key", std::string(300, 'k'));
  EXPECT_EQ(sample.Send(Method::kPost, "/api/v1/flights", "{}", headers).status, 400);
}

TEST(IdempotencyKeys, WhatIsDoneIsSaidAlsoWhereItCannotBeKept) {
  SampleService sample;
  ASSERT_TRUE(sample.service().db.Lock()->Exec(
      "CREATE TRIGGER full BEFORE INSERT ON idempotent_answer BEGIN SELECT RAISE(ABORT, 'full'); END"));
  Headers headers = Typed("application/json");
  headers.Add("Idempotency-Key", "k1");
  EXPECT_EQ(sample.Send(Method::kPost, "/api/v1/flights", R"({"name":"A"})", headers).status, 201);
}

TEST(IdempotencyKeys, KeepNoRefusal) {
  SampleService sample;
  const std::string flight = "/api/v1/flights/" + sample.NewFlight();
  Headers headers = Typed("application/json");
  headers.Add("Idempotency-Key", "k1");
  const auto ask = [&] { return sample.Send(Method::kPost, flight + "/jobs", "{}", headers); };
  EXPECT_EQ(ask().status, 409) << "it has no files yet";
  EXPECT_EQ(sample.Send(Method::kPut, flight + "/files/a.jpg", "x").status, 201);
  EXPECT_EQ(ask().status, 202);
  EXPECT_EQ(ask().headers.Find("Idempotency-Replayed"), "true");
}

TEST(Jobs, AreRetriedOnceTheyHaveEnded) {
  SampleService sample;
  const std::string flight = sample.NewFlight();
  EXPECT_EQ(sample.Send(Method::kPut, "/api/v1/flights/" + flight + "/files/a.jpg", "x").status, 201);
  const json job = JsonOf(sample.Send(Method::kPost, "/api/v1/flights/" + flight + "/jobs",
                                      R"({"options":{"quality":70}})", Typed("application/json")));
  const std::string at = "/api/v1/jobs/" + job["id"].get<std::string>();
  EXPECT_EQ(sample.Send(Method::kPost, at + "/retry").status, 409);
  EXPECT_EQ(sample.Send(Method::kDelete, at).status, 200);
  const Response retried = sample.Send(Method::kPost, at + "/retry");
  EXPECT_EQ(retried.status, 202);
  EXPECT_EQ(sample.queue.Get(JsonOf(retried)["id"])->options, R"({"quality":70})");
}

TEST(Ops, AnswerMonitors) {
  SampleService sample;
  EXPECT_EQ(sample.Get("/healthz").status, 200);
  EXPECT_EQ(sample.Get("/readyz").status, 200);
  EXPECT_EQ(JsonOf(sample.Get("/version"))["version"], "1.2.3");
  EXPECT_NE(sample.Get("/metrics").body.find("skyquilt_jobs{state=\"accepted\"} 0"), std::string::npos);
}

TEST(Jobs, TellThoseWhoRunTheServerWhichWorkerHasWhichPart) {
  SampleService sample;
  const Headers reader = sample.MakeToken("reader", storage::Scope::kRead);
  const Headers admin = sample.MakeToken("admin", storage::Scope::kAdmin);
  const std::string job = sample.queue.Add(sample.NewFlight(), "{}", storage::Now())->id;
  const std::string address = "/api/v1/jobs/" + job;
  EXPECT_FALSE(JsonOf(sample.Get(address, admin)).contains("parts"));  // it waits
  storage::UnitQueue units(sample.service().db);
  ASSERT_TRUE(*units.Cut(**sample.queue.Claim("w", storage::Now()), "look", 3, 10, {}));
  ASSERT_TRUE(*units.Claim("machine-7", storage::Now()));
  const Error full{ErrorCode::kOutOfSpace, "The disk is full.", ""};
  ASSERT_TRUE(storage::WorkersAside(sample.service().db).Put("machine-8", 2, full, storage::Now()));
  const json shown = JsonOf(sample.Get(address, admin));
  ASSERT_EQ(shown["parts"].size(), 1u);
  EXPECT_EQ(shown["parts"][0]["worker"], "machine-7");
  EXPECT_EQ(shown["parts"][0]["part"], 1);
  EXPECT_EQ(shown["parts"][0]["attempt"], 1);
  ASSERT_EQ(shown["workers_aside"].size(), 1u);
  EXPECT_EQ(shown["workers_aside"][0]["worker"], "machine-8");
  EXPECT_EQ(shown["workers_aside"][0]["times"], 2);
  EXPECT_EQ(shown["workers_aside"][0]["code"], "out_of_space");
  EXPECT_LT(shown["workers_aside"][0]["since"], shown["workers_aside"][0]["until"]);
  const json to_reader = JsonOf(sample.Get(address, reader));
  EXPECT_FALSE(to_reader.contains("parts"));
  EXPECT_FALSE(to_reader.contains("workers_aside"));
}

TEST(OpenApi, IsReadWithWhatToKnowAndWithWhatBodiesHold) {
  SampleService sample;
  const std::string page = sample.Get("/docs").body;
  for (const char* wanted :
       {"X-Skyquilt-Signature is ", "<code>options.gsd_m</code></td><td>Ground size of a pixel",
        "<code>points[].marks[].photo</code>", "at most 100 km", "<a href=\"openapi.json\">"})
    EXPECT_NE(page.find(wanted), std::string::npos) << wanted;
}

TEST(OpenApi, DescribesEveryRouteAndNoOther) {
  SampleService sample;
  const json document = JsonOf(sample.Get("/openapi.json"));
  std::set<std::string> described;
  for (const auto& [path, item] : document["paths"].items()) {
    for (const auto& [method, operation] : item.items()) {
      if (method != "parameters") described.insert(method + " " + path);
    }
  }
  std::set<std::string> served;
  for (const auto& [method, route] : sample.router().Routes()) {
    const std::string& pattern = route->pattern;
    std::string name = MethodName(method);
    for (char& c : name) c = static_cast<char>(std::tolower(c));
    // The router has no names for a part of a segment.
    const std::string path = pattern == "/tiles/{tileset}"            ? "/tiles/{flight}.json"
                             : pattern == "/tiles/{flight}/{tileset}" ? "/tiles/{flight}/{layer}.json"
                                                                      : pattern;
    served.insert(name + " " + path);
  }
  std::vector<std::string> in_one_alone;  // so that a failure names them: gtest prints long sets in part
  std::set_symmetric_difference(described.begin(), described.end(), served.begin(), served.end(),
                                std::back_inserter(in_one_alone));
  EXPECT_EQ(in_one_alone, std::vector<std::string>());
}

}  // namespace
}  // namespace skyquilt::api
