// What clients of the NodeODM-compatible node get: the lines of a long job, all and from one on, the files,
// and a task whatever they call it.
#include <fstream>

#include "tests/api/sample_service.h"

namespace skyquilt::api {
namespace {

constexpr const char* kToldTask = "11111111-2222-4333-8444-555555555555";

TEST(NodeOutput, HasTheLastLinesOfAJobOfManyStages) {
  SampleService sample;
  const std::string flight = sample.NewFlight();
  ASSERT_TRUE(sample.service().node_tasks.Add({kToldTask, flight, "[]", 1, true}));
  const auto job = sample.queue.Add(flight, "{}", storage::Now());
  ASSERT_TRUE(job);
  // As a job that is cut into units and taken up again and again leaves them.
  ASSERT_TRUE(sample.service().db.Lock()->Change(
      "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i+1 FROM n WHERE i<2500)"
      " INSERT INTO event(flight_id, job_id, kind, body)"
      " SELECT ?, ?, 'job', json_object('state', 'running', 'stage', 'stage' || i) FROM n",
      flight, job->id));
  const std::string output = "/task/" + std::string(kToldTask) + "/output";
  const nlohmann::json lines = sample.Json(output);
  ASSERT_EQ(lines.size(), 2501U) << "that it was accepted, and its stages";
  EXPECT_NE(lines.back().get<std::string>().find("stage2500"), std::string::npos) << lines.back();
  EXPECT_EQ(sample.Json(output + "?line=2499"), nlohmann::json::array({lines[2499], lines[2500]}));
  EXPECT_EQ(sample.Json(output + "?line=-1"), nlohmann::json::array({lines[2500]}));
  EXPECT_EQ(sample.Json("/task/" + std::string(kToldTask) + "/info?with_output=2500")["output"],
            nlohmann::json::array({lines[2500]}));
  const nlohmann::json log = sample.Json("/api/v1/jobs/" + job->id + "/log")["events"];
  ASSERT_EQ(log.size(), 2501U);
  EXPECT_EQ(log.back()["job"]["stage"], "stage2500");
}

TEST(NodeArchive, HasTheBandsOfACameraThatTookSeveral) {
  SampleService sample;
  const std::string flight = sample.NewFlight();
  const std::int64_t revision = sample.Publish(flight, {{0, 0, 0, "tile"}});
  ASSERT_TRUE(sample.service().node_tasks.Add({kToldTask, flight, "[]", 1, true}));
  const std::filesystem::path folder = sample.dir().Revision(flight, revision);
  for (const char* name : {"mosaic.tif", "mosaic.pmtiles", "bands.tif"})
    std::ofstream(folder / name) << "bytes of " << name;
  std::ofstream(folder / "report.json") << R"({"photos": {"total": 1}})";
  std::ofstream(folder / "photos.geojson") << R"({"features": []})";
  Response sent = sample.Get("/task/" + std::string(kToldTask) + "/download/all.zip");
  ASSERT_EQ(sent.status, 200) << sent.body;
  const std::string archive = BodyOf(sent);
  EXPECT_NE(archive.find("odm_orthophoto/odm_orthophoto.tif"), std::string::npos) << archive;
  EXPECT_NE(archive.find("odm_orthophoto/bands.tif"), std::string::npos);
  EXPECT_NE(archive.find("bytes of bands.tif"), std::string::npos);
}

TEST(NodeNewTask, CutsANameThatIsLongerThanAFlightMayHave) {
  SampleService sample;
  std::string name = "a";
  for (int i = 0; i < 120; ++i) name += "\xD0\xB6";  // a letter of two bytes
  const Headers as_json = {{"Content-Type", "application/json"}};
  const Response made =
      sample.Send(Method::kPost, "/task/new/init", nlohmann::json{{"name", name}}.dump(), as_json);
  const nlohmann::json answer = nlohmann::json::parse(made.body, nullptr, false);
  ASSERT_TRUE(answer.contains("uuid")) << made.body;
  const auto task = sample.service().node_tasks.Find(answer["uuid"].get<std::string>());
  ASSERT_TRUE(task);
  const auto flight = sample.catalogue.GetFlight(task->flight_id);
  ASSERT_TRUE(flight);
  EXPECT_EQ(flight->name, name.substr(0, 199)) << "whole letters";
  EXPECT_NE(task->notes.find("cut to 199 bytes"), std::string::npos) << task->notes;
}

TEST(NodeNewTask, KeepsTextsThatAreNotInUtf8AsWhatEveryCatalogueTakes) {
  SampleService sample;
  const Headers as_form = {{"Content-Type", "multipart/form-data; boundary=x"}};
  const Response made = sample.Send(
      Method::kPost, "/task/new/init",
      "--x\r\nContent-Disposition: form-data; name=\"name\"\r\n\r\nM\xFCller\r\n--x--\r\n", as_form);
  const nlohmann::json answer = nlohmann::json::parse(made.body, nullptr, false);
  ASSERT_TRUE(answer.contains("uuid")) << made.body;
  const std::string uuid = answer["uuid"];
  const Response sent = sample.Send(
      Method::kPost, "/task/new/upload/" + uuid,
      "--x\r\nContent-Disposition: form-data; name=\"images\"; filename=\"\xFC.jpg\"\r\n\r\nbytes\r\n--x--\r\n",
      as_form);
  EXPECT_EQ(sent.body, R"({"success":true})");
  const storage::NodeTask task = test::ValueOf(sample.service().node_tasks.Find(uuid));
  EXPECT_EQ(test::ValueOf(sample.catalogue.GetFlight(task.flight_id)).name, "M\xEF\xBF\xBDller");
  EXPECT_TRUE(task.notes.starts_with("\xEF\xBF\xBD.jpg was left out")) << task.notes;
}

}  // namespace
}  // namespace skyquilt::api
