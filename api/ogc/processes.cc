// OGC API - Processes 1.0: the same jobs as /api/v1/jobs, under the names that its clients know. One process,
// "stitch": a flight's photos in, its map out; always asynchronous.
// https://docs.ogc.org/is/18-062r2/18-062r2.html

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "api/common/feature_query.h"
#include "api/http/links.h"
#include "api/http/once.h"
#include "api/http/responses.h"
#include "api/jobs/jobs.h"
#include "api/json/json_codec.h"
#include "api/json/json_text.h"
#include "api/ogc/ogc_format.h"
#include "api/routes.h"
#include "core/base/text/json_io.h"
#include "core/base/try.h"

namespace skyquilt::api {
namespace {

using Value = nlohmann::ordered_json;

constexpr const char* kProcess = "stitch";
constexpr const char* kException = "http://www.opengis.net/def/exceptions/ogcapi-processes-1/1.0/";

Response Document(int status, const Value& value, const char* type = "application/json") {
  return NoCache(Text(status, JsonText(value), type));
}

Response Exception(int status, const char* type, const std::string& title, const std::string& detail,
                   const Request& request) {
  return Document(status,
                  {{"type", std::string(kException) + type},
                   {"title", title},
                   {"status", status},
                   {"detail", detail},
                   {"instance", request.path},
                   {"request_id", request.request_id}},
                  "application/problem+json");
}

Value Summary(const Request& request) {
  Value process;
  process["id"] = kProcess;
  process["title"] = "Stitch a flight";
  process["description"] = "From the aerial photos and logs of a flight to its map";
  process["version"] = "1.0.0";
  process["jobControlOptions"] = {"async-execute", "dismiss"};
  process["outputTransmission"] = {"reference"};
  process["links"] =
      Value::array({OgcLink(request, "/ogc/processes/stitch", "self", "application/json", "This process"),
                    OgcLink(request, "/ogc/processes/stitch/execution", kOgcRel + "execute",
                            "application/json", "Where to execute it")});
  return process;
}

Response ListProcesses(const Request& request) {
  return Document(200, {{"processes", Value::array({Summary(request)})},
                        {"links", Value::array({OgcLink(request, "/ogc/processes", "self", "application/json",
                                                        "This document")})}});
}

Value Output(const char* title, const char* type) {
  return {{"title", title}, {"schema", {{"type", "string"}, {"contentMediaType", type}}}};
}

Response DescribeProcess(const Request& request) {
  if (request.Parameter("process") != kProcess) {
    return Exception(404, "no-such-process", "No such process", "There is one process here: stitch.",
                     request);
  }
  Value process = Summary(request);
  process["inputs"] = {
      {"flight",
       {{"title", "Id of the flight, whose files are uploaded already"}, {"schema", {{"type", "string"}}}}},
      {"options",
       {{"title", "As in POST /api/v1/flights/{flight}/jobs"},
        {"minOccurs", 0},
        {"schema", {{"type", "object"}}}}}};
  process["outputs"] = {{"map", Output("TileJSON of the map", "application/json")},
                        {"cog", Output("Cloud-optimised GeoTIFF", "image/tiff")},
                        {"mbtiles", Output("MBTiles", "application/vnd.sqlite3")},
                        {"report", Output("How it was made", "application/json")}};
  return Document(200, process);
}

Value StatusInfo(const Request& request, const storage::Job& job) {
  Value info;
  info["jobID"] = job.id;
  info["processID"] = kProcess;
  info["type"] = "process";
  info["status"] = storage::JobStateName(job.state);
  info["message"] = job.state == storage::JobState::kFailed && job.error ? job.error->message : job.message;
  info["created"] = FormatTime(job.created);
  if (job.started) info["started"] = FormatTime(*job.started);
  if (job.finished) info["finished"] = FormatTime(*job.finished);
  info["progress"] = static_cast<int>(std::lround(100.0 * job.progress));
  const std::string self = "/ogc/jobs/" + job.id;
  info["links"] = Value::array({OgcLink(request, self, "self", "application/json", "This job")});
  if (job.state == storage::JobState::kSuccessful) {
    info["links"].push_back(
        OgcLink(request, self + "/results", kOgcRel + "results", "application/json", "Its results"));
  }
  return info;
}

// {"inputs": {"flight": ID, "options": {...}}}; what else the standard allows there changes nothing here.
struct Execution {
  std::string flight_id;
  std::optional<std::string> job_request;  // as the body of POST /flights/{id}/jobs
};

Result<Execution> ParseExecution(const std::string& body) {
  SKYQUILT_TRY(CheckJsonText(body));
  const Value parsed = ParseOrderedJson(body);
  const bool has_flight = parsed.is_object() && parsed.contains("inputs") && parsed["inputs"].is_object() &&
                          parsed["inputs"].contains("flight") && parsed["inputs"]["flight"].is_string();
  if (!has_flight) {
    return Error{ErrorCode::kInvalidArgument, "Send {\"inputs\": {\"flight\": \"the flight's id\"}}."};
  }
  Execution execution;
  execution.flight_id = parsed["inputs"]["flight"].get<std::string>();
  Value request = Value::object();
  for (const auto& [name, value] : parsed["inputs"].items()) {
    if (name != "flight") request[name] = value;
  }
  execution.job_request = JsonText(request);
  return execution;
}

Result<Response> Execute(Service& service, const Request& request, const std::string& body) {
  SKYQUILT_TRY_ASSIGN(const Execution execution, ParseExecution(body));
  SKYQUILT_TRY_ASSIGN(const storage::Job job,
                      QueueJob(service, request, execution.flight_id, *execution.job_request));
  Response response = Document(201, StatusInfo(request, job));
  response.headers.Add("Location", request.base_url + "/ogc/jobs/" + job.id);
  response.headers.Add("Preference-Applied", "respond-async");
  return response;
}

Result<Response> NoJob(const Error& error, const Request& request) {
  if (error.code != ErrorCode::kNotFound) return error;
  return Exception(404, "no-such-job", "No such job", "There is no job of this id.", request);
}

Result<Response> Jobs(Service& service, const Request& request) {
  constexpr int kUsualJobs = 200, kMaxJobs = 500;
  SKYQUILT_TRY_ASSIGN(const int limit, ParseLimit(request.Query("limit").value_or(""), kUsualJobs, kMaxJobs));
  SKYQUILT_TRY_ASSIGN(const JobPage page, PageOfJobs(service, request, std::nullopt, limit));
  Value list = Value::array();
  for (const storage::Job& job : page.jobs) list.push_back(StatusInfo(request, job));
  Value links = Value::array({OgcLink(request, "/ogc/jobs", "self", "application/json", "This document")});
  if (page.next_cursor) {
    links.push_back(OgcLink(request, fmt::format("/ogc/jobs?limit={}&cursor={}", limit, *page.next_cursor),
                            "next", "application/json", "The jobs before these"));
  }
  return Document(200, {{"jobs", list}, {"links", links}});
}

Result<Response> Status(Service& service, const Request& request) {
  const Result<storage::Job> job = service.queue.Get(request.Parameter("job"));
  if (!job) return NoJob(job.error(), request);
  return Document(200, StatusInfo(request, *job));
}

Result<Response> Dismiss(Service& service, const Request& request) {
  const std::string& id = request.Parameter("job");
  Result<storage::Job> job = service.queue.Get(id);
  if (!job) return NoJob(job.error(), request);
  if (job->finished) {
    SKYQUILT_TRY(service.queue.Remove(id));
  } else {
    job = service.queue.Cancel(id, storage::Now());
    if (!job) return job.error();
  }
  Value info = StatusInfo(request, *job);
  // A running one ends within a second; what is asked for is done.
  info["status"] = storage::JobStateName(storage::JobState::kDismissed);
  return Document(200, info);
}

Result<Response> Results(Service& service, const Request& request) {
  const Result<storage::Job> job = service.queue.Get(request.Parameter("job"));
  if (!job) return NoJob(job.error(), request);
  if (job->state == storage::JobState::kFailed) {
    return Error{ErrorCode::kUnprocessable, job->error ? job->error->message : "The job failed."};
  }
  if (job->state != storage::JobState::kSuccessful) {
    return Exception(404, "result-not-ready", "Result not ready", "This job has no results (yet).", request);
  }
  const std::string flight = "/api/v1/flights/" + job->flight_id;
  const auto file = [&](const std::string& path, const char* type) {
    return Value{{"href", LinkTo(request, path)}, {"type", type}};
  };
  return Document(200, {{"map", file("/tiles/" + job->flight_id + ".json", "application/json")},
                        {"cog", file(flight + "/download.tif", "image/tiff")},
                        {"mbtiles", file(flight + "/download.mbtiles", "application/vnd.sqlite3")},
                        {"report", file(flight + "/report", "application/json")}});
}

}  // namespace

void AddProcessRoutes(Router& router, Service& service) {
  router.Add(Method::kGet, "/ogc/processes", ListProcesses);
  router.Add(Method::kGet, "/ogc/processes/{process}", DescribeProcess);
  router.AddBody(
      Method::kPost, "/ogc/processes/stitch/execution",
      [&](const Request& request, const std::string& body) {
        return Once(service, request, body, [&] { return Execute(service, request, body); });
      },
      "Send the inputs as JSON with its header: curl -H 'Content-Type: application/json' -d '{}' ...");
  router.Add(Method::kGet, "/ogc/jobs", On(service, Jobs));
  router.Add(Method::kGet, "/ogc/jobs/{job}", On(service, Status));
  router.Add(Method::kDelete, "/ogc/jobs/{job}", On(service, Dismiss));
  router.Add(Method::kGet, "/ogc/jobs/{job}/results", On(service, Results));
}

}  // namespace skyquilt::api
