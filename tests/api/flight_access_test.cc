// Whose flight it is: every route that changes something, asked by the owner of another flight; and tokens
// that open one flight alone.
#include "api/auth/flight_access.h"

#include <map>
#include <set>

#include "api/http/digest.h"
#include "tests/api/sample_service.h"

namespace skyquilt::api {
namespace {

using storage::Scope;

constexpr const char* kUuid = "11111111-2222-4333-8444-555555555555";
constexpr const char* kBusyUuid = "31111111-2222-4333-8444-555555555555";
constexpr const char* kOpenUuid = "21111111-2222-4333-8444-555555555555";
constexpr const char* kFormBody =
    "--b\r\nContent-Disposition: form-data; name=\"images\"; filename=\"new.jpg\"\r\n\r\nbytes\r\n--b--\r\n";

// What one token has: a flight with a file, a job, an upload, and two tasks.
struct World {
  SampleService sample;
  Headers owner = sample.MakeToken("owner", Scope::kUpload);
  Headers other = sample.MakeToken("other", Scope::kUpload);
  Headers admin = sample.MakeToken("admin", Scope::kAdmin);
  std::string flight = NewFlight();
  std::string job = sample.queue.Add(flight, "{}", storage::Now(), {0, "owner"})->id;
  std::string ended_flight = NewFlight();
  std::string ended_job = EndedJob();
  std::string free_flight = NewFlight();  // without a job
  std::string upload = NewUpload();
  std::string task_flight = NewTask(kUuid, true);
  std::string open_task_flight = NewTask(kOpenUuid, false);
  std::string busy_task_flight = NewBusyTask();
  std::string trashed_flight = NewTrashedFlight();
  Headers share = sample.MakeToken("shared", Scope::kRead, {}, free_flight);

  std::string NewFlight() {
    const std::string id = sample.catalogue.AddFlight("field", "{}", storage::Now(), "owner")->id;
    AddFile(id);
    return id;
  }
  void AddFile(const std::string& id) {
    const std::string path = "/api/v1/flights/" + id + "/files/a.jpg";
    EXPECT_EQ(sample.Send(Method::kPut, path, "abc", owner).status, 201);
  }
  std::string NewTrashedFlight() {
    const std::string id = NewFlight();
    EXPECT_EQ(sample.Send(Method::kDelete, "/api/v1/flights/" + id, "", owner).status, 204);
    return id;
  }
  std::string EndedJob() {
    const std::string id = sample.queue.Add(ended_flight, "{}", storage::Now(), {0, "owner"})->id;
    EXPECT_TRUE(sample.queue.Cancel(id, storage::Now()));
    return id;
  }
  std::string NewUpload() {
    storage::SpooledUpload wish;
    wish.flight_id = free_flight;
    wish.name = "b.jpg";
    wish.length = 5;
    wish.owner = "owner";
    return sample.service().spool.Create(wish, storage::Now())->id;
  }
  std::string NewBusyTask() {
    const std::string id = NewFlight();
    EXPECT_TRUE(sample.service().node_tasks.Add({kBusyUuid, id, "[]", 1, true}));
    EXPECT_TRUE(sample.queue.Add(id, "{}", storage::Now()));
    return id;
  }
  std::string NewTask(const char* uuid, bool is_committed) {
    const std::string id = NewFlight();
    EXPECT_TRUE(sample.service().node_tasks.Add({uuid, id, "[]", 1, is_committed}));
    if (is_committed) {
      EXPECT_TRUE(sample.queue.Cancel(sample.queue.Add(id, "{}", storage::Now())->id, storage::Now()));
    }
    return id;
  }
};

Headers With(Headers headers, std::initializer_list<std::pair<const char*, std::string>> more) {
  for (const auto& [name, value] : more) headers.Add(name, value);
  return headers;
}

using Ask = std::function<Response(World&, const Headers&)>;

Ask Sends(Method method, std::function<std::string(World&)> target, std::function<std::string(World&)> body,
          std::initializer_list<std::pair<const char*, std::string>> more) {
  std::vector<std::pair<const char*, std::string>> headers = more;
  return [=](World& world, const Headers& who) {
    Headers all = who;
    for (const auto& [name, value] : headers) all.Add(name, value);
    return world.sample.Send(method, target(world), body(world), all);
  };
}

Ask Sends(Method method, std::function<std::string(World&)> target, const std::string& body = "",
          std::initializer_list<std::pair<const char*, std::string>> more = {}) {
  return Sends(
      method, std::move(target), [body](World&) { return body; }, more);
}

std::string FormType() { return "multipart/form-data; boundary=b"; }

// Each route of scope upload that acts on something that is there, acting on what the owner has.
std::map<std::pair<Method, std::string>, Ask> Asks() {
  using M = Method;
  const auto at_flight = [](std::string rest) {
    return [rest](World& w) { return "/api/v1/flights/" + w.free_flight + rest; };
  };
  const auto at_upload = [](World& w) { return "/api/v1/uploads/" + w.upload; };
  const auto at = [](std::string path) { return [path](World&) { return path; }; };
  const std::string task = std::string("uuid=") + kUuid;
  std::map<std::pair<Method, std::string>, Ask> asks;
  asks[{M::kDelete, "/api/v1/flights/{flight}"}] = Sends(M::kDelete, at_flight(""));
  asks[{M::kPatch, "/api/v1/flights/{flight}"}] = Sends(M::kPatch, at_flight(""), R"({"name":"mine"})");
  asks[{M::kPost, "/api/v1/flights/{flight}/files"}] =
      Sends(M::kPost, at_flight("/files"), kFormBody, {{"Content-Type", FormType()}});
  asks[{M::kPut, "/api/v1/flights/{flight}/files/{name}"}] =
      Sends(M::kPut, at_flight("/files/a.jpg"), "other", {{"If-Match", "*"}});
  asks[{M::kPut, "/api/v1/flights/{flight}/control"}] = [](World& w, const Headers& who) {
    w.sample.service().read_control = [](const std::filesystem::path&) {
      return Result<std::string>(std::string(R"({"points":[{"name":"a"}]})"));
    };
    const std::string point = R"({"points":[{"name":"a","x":7.1,"y":46.8}]})";
    return w.sample.Send(M::kPut, "/api/v1/flights/" + w.free_flight + "/control", point, who);
  };
  asks[{M::kPut, "/api/v1/flights/{flight}/notes"}] = Sends(
      M::kPut, at_flight("/notes"),
      R"({"type":"FeatureCollection","features":[{"type":"Feature","id":"a","properties":{"name":"mine"},"geometry":{"type":"Point","coordinates":[7.1,46.8]}}]})");
  asks[{M::kDelete, "/api/v1/flights/{flight}/files/{name}"}] = Sends(M::kDelete, at_flight("/files/a.jpg"));
  asks[{M::kPost, "/api/v1/flights/{flight}/jobs"}] = Sends(M::kPost, at_flight("/jobs"), "{}");
  asks[{M::kGet, "/api/v1/flights/{flight}/shares"}] = Sends(M::kGet, at_flight("/shares"));
  asks[{M::kPost, "/api/v1/flights/{flight}/shares"}] = Sends(M::kPost, at_flight("/shares"), "{}");
  asks[{M::kDelete, "/api/v1/flights/{flight}/shares/{share}"}] =
      Sends(M::kDelete, at_flight("/shares/shared"));
  asks[{M::kPost, "/api/v1/flights/{flight}/restore"}] =
      Sends(M::kPost, [](World& w) { return "/api/v1/flights/" + w.trashed_flight + "/restore"; });
  asks[{M::kDelete, "/api/v1/trash/{flight}"}] =
      Sends(M::kDelete, [](World& w) { return "/api/v1/trash/" + w.trashed_flight; });
  asks[{M::kPost, "/api/v1/jobs/{job}/retry"}] =
      Sends(M::kPost, [](World& w) { return "/api/v1/jobs/" + w.ended_job + "/retry"; });
  asks[{M::kDelete, "/api/v1/jobs/{job}"}] =
      Sends(M::kDelete, [](World& w) { return "/api/v1/jobs/" + w.job; });
  asks[{M::kPost, "/api/v1/uploads"}] = [](World& w, const Headers& who) {
    const std::string metadata =
        "flight " + EncodeBase64(w.free_flight) + ",filename " + EncodeBase64(std::string("c.jpg"));
    return w.sample.Send(
        M::kPost, "/api/v1/uploads", "",
        With(who, {{"Tus-Resumable", "1.0.0"}, {"Upload-Length", "5"}, {"Upload-Metadata", metadata}}));
  };
  asks[{M::kPatch, "/api/v1/uploads/{upload}"}] =
      Sends(M::kPatch, at_upload, "01234",
            {{"Tus-Resumable", "1.0.0"},
             {"Upload-Offset", "0"},
             {"Content-Type", "application/offset+octet-stream"}});
  asks[{M::kPost, "/api/v1/uploads/{upload}"}] = Sends(M::kPost, at_upload, "01234",
                                                       {{"Tus-Resumable", "1.0.0"},
                                                        {"X-HTTP-Method-Override", "PATCH"},
                                                        {"Upload-Offset", "0"},
                                                        {"Content-Type", "application/offset+octet-stream"}});
  asks[{M::kDelete, "/api/v1/uploads/{upload}"}] =
      Sends(M::kDelete, at_upload, "", {{"Tus-Resumable", "1.0.0"}});
  asks[{M::kPost, "/task/new/upload/{uuid}"}] = Sends(
      M::kPost, at(std::string("/task/new/upload/") + kOpenUuid), kFormBody, {{"Content-Type", FormType()}});
  asks[{M::kPost, "/task/new/commit/{uuid}"}] =
      Sends(M::kPost, at(std::string("/task/new/commit/") + kOpenUuid));
  asks[{M::kPost, "/task/remove"}] = Sends(M::kPost, at("/task/remove"), task);
  asks[{M::kPost, "/task/restart"}] = Sends(M::kPost, at("/task/restart"), task);
  asks[{M::kPost, "/task/cancel"}] = Sends(M::kPost, at("/task/cancel"), std::string("uuid=") + kBusyUuid);
  asks[{M::kPost, "/ogc/processes/stitch/execution"}] =
      Sends(M::kPost, at("/ogc/processes/stitch/execution"),
            [](World& w) { return R"({"inputs":{"flight":")" + w.free_flight + "\"}}"; }, {});
  asks[{M::kDelete, "/ogc/jobs/{job}"}] = Sends(M::kDelete, [](World& w) { return "/ogc/jobs/" + w.job; });
  return asks;
}

// They make something of one's own.
const std::set<std::pair<Method, std::string>> kMakes = {
    {Method::kPost, "/api/v1/flights"}, {Method::kPost, "/task/new"}, {Method::kPost, "/task/new/init"}};

bool IsRefused(const Response& response) {
  if (response.status == 403 || response.status == 404) return true;
  return response.status == 200 && response.body.find("\"error\":\"") != std::string::npos;
}

// All that others could have changed, as text.
std::string StateOf(World& w) {
  std::string state = std::to_string(*w.sample.catalogue.BytesOf("owner"));  // uploads that are coming too
  const auto ids = w.sample.catalogue.FlightIds();
  for (const std::string& id : *ids) {
    const auto flight = w.sample.catalogue.GetFlight(id);
    const auto files = w.sample.catalogue.ListFiles(id);
    const auto jobs = w.sample.queue.List(id, 100);
    state += id + (flight ? flight->name + flight->options + std::to_string(flight->bytes) : "gone");
    for (const auto& file : *files) state += file.name + file.stored_name;
    for (const auto& job : *jobs) state += job.id + storage::JobStateName(job.state);
  }
  const auto set = w.sample.service().tokens.Read();
  for (const auto& token : set->tokens) state += token.id + token.flight_id;
  for (const char* uuid : {kUuid, kOpenUuid}) {
    const auto task = w.sample.service().node_tasks.Find(uuid);
    state += task ? uuid + std::to_string(task->is_committed) : "gone";
  }
  const auto upload = w.sample.service().spool.Find(w.upload, storage::Now());
  return state + (upload ? std::to_string(upload->offset) : "gone");
}

TEST(FlightAccess, NoRouteChangesWhatIsAnothers) {
  const auto asks = Asks();
  World table;
  for (const auto& [method, route] : table.sample.router().Routes()) {
    const std::string& pattern = route->pattern;
    if (route->scope != Scope::kUpload || kMakes.contains({method, pattern})) continue;
    const std::string what = std::string(MethodName(method)) + " " + pattern;
    const auto ask = asks.find({method, pattern});
    ASSERT_NE(ask, asks.end()) << what
                               << " changes something: say here what it must not do to another's flight";
    World world;
    const std::string before = StateOf(world);
    const Response refused = ask->second(world, world.other);
    EXPECT_TRUE(IsRefused(refused)) << what << " " << refused.status << " " << refused.body;
    EXPECT_EQ(StateOf(world), before) << what;
    // The same by its owner is done: else the refusal would prove nothing.
    const Response done = ask->second(world, world.owner);
    EXPECT_FALSE(IsRefused(done)) << what << " " << done.status << " " << done.body;
    if (method != Method::kGet) {
      EXPECT_NE(StateOf(world), before) << what;
    }
  }
}

TEST(FlightAccess, WhatWasDeletedIsSeenByWhoMayTakeItBack) {
  World world;
  const auto is_told = [&](const Headers& who) {
    return world.sample.Get("/api/v1/trash", who).body.find(world.trashed_flight) != std::string::npos;
  };
  EXPECT_TRUE(is_told(world.owner));
  EXPECT_TRUE(is_told(world.admin));
  EXPECT_FALSE(is_told(world.other));
}

TEST(FlightAccess, AFlightOfNobodyIsForAdmins) {
  World world;
  const std::string flight = world.sample.NewFlight();
  const std::string at = "/api/v1/flights/" + flight;
  EXPECT_EQ(world.sample.Send(Method::kPatch, at, R"({"name":"x"})", world.other).status, 403);
  EXPECT_EQ(world.sample.Get(at, world.other).status, 200);
  EXPECT_EQ(world.sample.Send(Method::kPatch, at, R"({"name":"x"})", world.admin).status, 200);
}

TEST(FlightAccess, ATokenOfOneFlightReadsThatOneAlone) {
  World world;
  world.sample.Publish(world.ended_flight, {{1, 0, 1, "tile"}});
  world.sample.Publish(world.free_flight, {{1, 0, 1, "tile"}});
  const Headers share = world.sample.MakeToken("share", Scope::kAdmin, {}, world.ended_flight);
  // Whatever scope it was given, it reads.
  const std::string at = "/api/v1/flights/" + world.ended_flight;
  EXPECT_EQ(world.sample.Send(Method::kPatch, at, R"({"name":"x"})", share).status, 403);
  EXPECT_EQ(world.sample.Send(Method::kPost, "/api/v1/flights", "{}", share).status, 403);
  for (const auto& [method, route] : world.sample.router().Routes()) {
    if (method != Method::kGet || route->scope != Scope::kRead) continue;
    const auto target = [&, &path = route->pattern](const World& w, const std::string& flight) {
      std::string text = path;
      const std::pair<std::string, std::string> values[] = {
          {"{flight}", flight},
          {"{tileset}", path.find("{flight}") == std::string::npos ? flight + ".json" : "photo.json"},
          {"{job}", flight == w.ended_flight ? w.ended_job : w.job},
          {"{uuid}", kUuid},
          {"{upload}", w.upload},
          {"{name}", "a.jpg"},
          {"{z}", "1"},
          {"{x}", "0"},
          {"{y}", "0.png"},
          {"{row}", "0"},
          {"{size}", "256"},
          {"{column}", "0"},
          {"{matrix}", "1"},
          {"{set}", "WebMercatorQuad"},
          {"{layer}", "map"},
          {"{style}", "default"},
          {"{asset}", "all.zip"},
          {"{export}", w.job},
          {"{item}", flight + "-r1"},
          {"{feature}", "a.jpg"},
          {"{operation}", "identify"},
          {"{process}", "stitch"}};
      for (const auto& [name, value] : values) {
        for (std::size_t found = text.find(name); found != std::string::npos; found = text.find(name)) {
          text.replace(found, name.size(), value);
        }
      }
      return text;
    };
    EXPECT_EQ(target(world, world.ended_flight).find('{'), std::string::npos) << route->pattern;
    const std::string one = target(world, world.ended_flight);
    const std::string other = target(world, world.flight);
    if (one != other) {
      Response refused = world.sample.Get(other, share);
      EXPECT_EQ(refused.status, 404) << other << " " << refused.body;
      EXPECT_NE(refused.body.find("opens one flight"), std::string::npos) << other << " " << refused.body;
      Response own = world.sample.Get(one, share);
      EXPECT_EQ(BodyOf(own).find("opens one flight"), std::string::npos) << one;
    } else if (route->pattern != "/api/v1/events") {
      // Without a flight in the address it tells nothing of others.
      Response told = world.sample.Get(one, share);
      const std::string body = BodyOf(told);
      for (const std::string& foreign : {world.flight, world.free_flight, world.task_flight,
                                         world.trashed_flight, world.job, std::string(kUuid)}) {
        EXPECT_EQ(body.find(foreign), std::string::npos) << one << " " << body;
      }
    }
  }
  EXPECT_EQ(world.sample.Get("/arcgis/rest/info", share).status, 200);  // which ArcGIS asks before a map
  EXPECT_NE(world.sample.Get("/api/v1/flights", share).body.find(world.ended_flight), std::string::npos);
  EXPECT_NE(world.sample.Get("/api/v1/jobs", share).body.find(world.ended_job), std::string::npos);
  EXPECT_EQ(world.sample.Get("/api/v1/jobs?flight=" + world.flight, share).body,
            R"({"jobs":[],"next_cursor":null})");
  EXPECT_EQ(world.sample.Get("/api/v1/events?flight=" + world.flight, share).status, 404);
  EXPECT_EQ(world.sample.Get("/api/v1/events?job=" + world.job, share).status, 404);
  Response events = world.sample.Get("/api/v1/events?after=0", share);
  ASSERT_NE(events.live, nullptr);
  const std::string told = *events.live->Next();
  EXPECT_NE(told.find(world.ended_flight), std::string::npos);
  EXPECT_EQ(told.find(world.flight), std::string::npos);
  // A stream ends with its token.
  ASSERT_TRUE(world.sample.service().tokens.Revoke("share"));
  EXPECT_FALSE(events.live->Next());
}

// The server asks nobody for a token: a link is good until it is revoked all the same.
TEST(FlightAccess, AStreamEndsWithTheLinkThatOpenedIt) {
  SampleService sample;
  const std::string at = "/api/v1/flights/" + sample.NewFlight() + "/shares";
  const auto share = nlohmann::json::parse(sample.Send(Method::kPost, at).body);
  const std::string token = share["token"];
  Response events = sample.Get("/api/v1/events", {{"Authorization", "Bearer " + token}});
  ASSERT_NE(events.live, nullptr);
  EXPECT_TRUE(events.live->Next());
  ASSERT_EQ(sample.Send(Method::kDelete, at + "/" + share["id"].get<std::string>()).status, 204);
  EXPECT_FALSE(events.live->Next());
}

TEST(FlightAccess, ATokenGoesWithItsFlight) {
  World world;
  const Headers share = world.sample.MakeToken("share", Scope::kRead, {}, world.flight);
  ASSERT_TRUE(world.sample.catalogue.DeleteFlight(world.flight));
  const auto set = storage::Tokens(world.sample.service().db).Read();
  for (const storage::Token& token : set->tokens) EXPECT_NE(token.id, "share");
}

}  // namespace
}  // namespace skyquilt::api
