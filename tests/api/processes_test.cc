// OGC API Processes, and what a token may take.
#include <set>

#include "api/auth/limits.h"
#include "tests/api/sample_service.h"

namespace skyquilt::api {
namespace {

using nlohmann::json;

Headers JsonType() { return {{"Content-Type", "application/json"}}; }

TEST(Processes, AJobIsExecutedLookedAtDismissedAndForgotten) {
  SampleService sample;
  const std::string flight = sample.NewFlight();
  const std::string inputs = R"({"inputs":{"flight":")" + flight + R"(","options":{"quality":80}}})";
  const char* kExecute = "/ogc/processes/stitch/execution";
  EXPECT_EQ(sample.Send(Method::kPost, kExecute, inputs, JsonType()).status, 409);  // no files yet
  sample.Send(Method::kPut, "/api/v1/flights/" + flight + "/files/a.jpg", "bytes");
  const Response made = sample.Send(Method::kPost, kExecute, inputs, JsonType());
  ASSERT_EQ(made.status, 201) << made.body;
  const json info = json::parse(made.body);
  EXPECT_EQ(info["status"], "accepted");
  const std::string job = info["jobID"];
  EXPECT_EQ(made.headers.Find("Location"), "http://127.0.0.1:1/ogc/jobs/" + job);
  EXPECT_EQ(json::parse(sample.Get("/ogc/jobs").body)["jobs"].size(), 1u);
  EXPECT_EQ(json::parse(sample.Get("/api/v1/jobs/" + job).body)["state"], "accepted");
  const Response results = sample.Get("/ogc/jobs/" + job + "/results");
  EXPECT_EQ(results.status, 404);
  EXPECT_TRUE(json::parse(results.body)["type"].get<std::string>().ends_with("result-not-ready"));
  EXPECT_EQ(json::parse(sample.Send(Method::kDelete, "/ogc/jobs/" + job).body)["status"], "dismissed");
  EXPECT_EQ(sample.queue.Get(job)->state, storage::JobState::kDismissed);
  EXPECT_EQ(sample.Send(Method::kDelete, "/ogc/jobs/" + job).status, 200);
  const Response gone = sample.Get("/ogc/jobs/" + job);
  EXPECT_EQ(gone.status, 404);
  EXPECT_TRUE(json::parse(gone.body)["type"].get<std::string>().ends_with("no-such-job"));
}

TEST(Processes, JobsHavePages) {
  SampleService sample;
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(sample.queue.Add(sample.NewFlight(), "{}", storage::Now()));
  const json first = json::parse(sample.Get("/ogc/jobs?limit=2").body);
  ASSERT_EQ(first["links"].size(), 2u);
  EXPECT_EQ(first["links"][1]["rel"], "next");
  const std::string next = first["links"][1]["href"];
  const json last = json::parse(sample.Get(next.substr(next.find("/ogc/"))).body);
  EXPECT_EQ(last["links"].size(), 1u);
  std::set<std::string> seen;
  for (const json& page : {first, last}) {
    for (const json& job : page["jobs"]) seen.insert(job["jobID"].get<std::string>());
  }
  EXPECT_EQ(first["jobs"].size(), 2u);
  EXPECT_EQ(seen.size(), 3u);
  EXPECT_EQ(sample.Get("/ogc/jobs?limit=0").status, 400);
  EXPECT_EQ(sample.Get("/ogc/jobs?cursor=0").status, 400);
}

TEST(Processes, DescribesItselfAndRefusesWhatItDoesNotKnow) {
  SampleService sample;
  const json process = json::parse(sample.Get("/ogc/processes/stitch").body);
  EXPECT_TRUE(process["inputs"].contains("flight"));
  EXPECT_TRUE(process["outputs"].contains("cog"));
  EXPECT_EQ(sample.Get("/ogc/processes/paint").status, 404);
  for (const char* bad : {"", "[]", "{}", R"({"inputs":{"flight":7}})"}) {
    EXPECT_EQ(sample.Send(Method::kPost, "/ogc/processes/stitch/execution", bad, JsonType()).status, 400)
        << bad;
  }
  const std::string unknown = R"({"inputs":{"flight":")" + sample.NewFlight() + R"(","colour":1}})";
  EXPECT_EQ(sample.Send(Method::kPost, "/ogc/processes/stitch/execution", unknown, JsonType()).status, 422);
}

TEST(RateLimiter, GivesAMinutesWorthAndFillsAgain) {
  RateLimiter limiter;
  const auto begin = RateLimiter::Clock::now();
  for (int i = 0; i < 60; ++i) EXPECT_TRUE(limiter.Take("a", 60, begin)) << i;
  EXPECT_FALSE(limiter.Take("a", 60, begin));
  EXPECT_TRUE(limiter.Take("b", 60, begin));
  EXPECT_TRUE(limiter.Take("a", 60, begin + std::chrono::milliseconds(1100)));
  EXPECT_FALSE(limiter.Take("a", 60, begin + std::chrono::milliseconds(1100)));
}

TEST(Limits, RequestsAreCounted) {
  SampleService sample;
  storage::Token token{"t", "t", HashToken("sq_x"), storage::Scope::kRead, storage::Now(), std::nullopt};
  token.requests_per_minute = 100;
  ASSERT_TRUE(sample.service().tokens.Add(token));
  const auto status = [&] {
    Request request;
    request.headers.Add("Authorization", "Bearer sq_x");
    const auto refused = CheckAccess(sample.service(), request,
                                     *sample.router().Find(Method::kGet, {"api", "v1", "flights"}).route);
    EXPECT_EQ(request.owner, "t");
    return refused ? refused->status : 0;
  };
  int allowed = 0;
  while (allowed < 200 && status() == 0) ++allowed;
  EXPECT_EQ(allowed, 100);
  EXPECT_EQ(status(), 429);
}

}  // namespace
}  // namespace skyquilt::api
