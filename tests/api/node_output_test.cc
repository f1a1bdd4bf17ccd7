// What clients of the NodeODM-compatible node read of a long job: all lines, and from a line on.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "tests/api/sample_service.h"

namespace skyquilt::api {
namespace {

TEST(NodeOutput, HasTheLastLinesOfAJobOfManyStages) {
  SampleService sample;
  const std::string uuid = "11111111-2222-4333-8444-555555555555";
  const std::string flight = sample.NewFlight();
  ASSERT_TRUE(sample.service().node_tasks.Add({uuid, flight, "[]", 1, true}));
  const auto job = sample.queue.Add(flight, "{}", storage::Now());
  ASSERT_TRUE(job);
  // As a job that is cut into units and taken up again and again leaves them.
  ASSERT_TRUE(sample.service().db.Lock()->Change(
      "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i+1 FROM n WHERE i<2500)"
      " INSERT INTO event(flight_id, job_id, kind, body)"
      " SELECT ?, ?, 'job', json_object('state', 'running', 'stage', 'stage' || i) FROM n",
      flight, job->id));
  const std::string output = "/task/" + uuid + "/output";
  const nlohmann::json lines = sample.Json(output);
  ASSERT_EQ(lines.size(), 2501U) << "that it was accepted, and its stages";
  EXPECT_NE(lines.back().get<std::string>().find("stage2500"), std::string::npos) << lines.back();
  EXPECT_EQ(sample.Json(output + "?line=2499"), nlohmann::json::array({lines[2499], lines[2500]}));
  EXPECT_EQ(sample.Json(output + "?line=-1"), nlohmann::json::array({lines[2500]}));
  EXPECT_EQ(sample.Json("/task/" + uuid + "/info?with_output=2500")["output"],
            nlohmann::json::array({lines[2500]}));
}

}  // namespace
}  // namespace skyquilt::api
