#include <fmt/format.h>
#include <sys/sysinfo.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "api/http/parameters.h"
#include "api/http/responses.h"
#include "api/json/json_codec.h"
#include "api/nodeodm/node_options.h"
#include "api/nodeodm/nodeodm.h"
#include "api/routes.h"
#include "core/base/text/json_io.h"
#include "core/base/try.h"

namespace skyquilt::api {
namespace {

using Value = nlohmann::ordered_json;
using storage::JobState;

constexpr const char* kApiVersion = "2.2.4";  // of the contract; clients choose their way by it

// A job that a worker is about to take is running to its client, who otherwise takes the node for busy.
Result<bool> IsNext(Service& service) {
  SKYQUILT_TRY_ASSIGN(const int unfinished, service.queue.CountUnfinished(service.worker_count + 1));
  return unfinished <= service.worker_count;
}

Result<int> StatusCode(Service& service, const storage::NodeTask& task,
                       const std::optional<storage::Job>& job) {
  if (!job) return 10;
  if (job->cancel_requested || job->id == task.canceled_job) return 50;
  switch (job->state) {
    case JobState::kAccepted: {
      SKYQUILT_TRY_ASSIGN(const bool is_next, IsNext(service));
      return is_next ? 20 : 10;
    }
    case JobState::kRunning:
      return 20;
    case JobState::kFailed:
      return 30;
    case JobState::kSuccessful:
      return 40;
    case JobState::kDismissed:
      return 50;
  }
  return 30;
}

std::int64_t ProcessingMs(const std::optional<storage::Job>& job) {
  if (!job || !job->started) return -1;
  const storage::Time end = job->finished.value_or(storage::Now());
  return std::chrono::duration_cast<std::chrono::milliseconds>(end - *job->started).count();
}

// Linux's own figure counts what caches would give back.
std::uint64_t AvailableMemoryBytes() {
  std::ifstream meminfo("/proc/meminfo");
  std::string name;
  std::uint64_t kib = 0;
  std::string unit;
  while (meminfo >> name >> kib) {
    if (name == "MemAvailable:") return kib * 1024;
    std::getline(meminfo, unit);
  }
  return 0;
}

Response Info(Service& service, const Request& request) {
  const Result<storage::JobCounts> jobs = service.queue.Count();
  if (!jobs) return Problem(jobs.error(), request);
  struct sysinfo machine {};
  sysinfo(&machine);
  Value answer;
  answer["version"] = kApiVersion;
  answer["taskQueueCount"] = jobs->accepted + jobs->running;
  answer["totalMemory"] = std::uint64_t{machine.totalram} * machine.mem_unit;
  answer["availableMemory"] = AvailableMemoryBytes();
  answer["cpuCores"] = std::max(1U, std::thread::hardware_concurrency());
  answer["maxImages"] = nullptr;
  answer["maxParallelTasks"] = std::max(1, service.worker_count);
  answer["engineVersion"] = service.version;
  answer["engine"] = service.node_engine;
  return NodeAnswer(JsonText(answer));
}

// Nobody logs in here: an operator gives out tokens, or lets everybody in.
Response AuthInfo(Service& service, const Request& request) {
  const char* message = service.tokens.RequiresToken() || request.needs_token
                            ? "Skyquilt takes the tokens that its operator gives out."
                            : "Authentication not available on this node";
  return NodeAnswer(JsonText(Value{{"message", message}, {"loginUrl", nullptr}, {"registerUrl", nullptr}}));
}

Result<Response> ListTasks(Service& service, const Request&) {
  SKYQUILT_TRY_ASSIGN(const std::vector<std::string> uuids, service.node_tasks.List());
  Value list = Value::array();
  for (const std::string& uuid : uuids) list.push_back({{"uuid", uuid}});
  return NodeAnswer(JsonText(list));
}

// From line `from` on; a negative one counts from the end.
Value LinesFrom(const std::vector<std::string>& lines, std::int64_t from) {
  const auto count = static_cast<std::int64_t>(lines.size());
  if (from < 0) from = std::max<std::int64_t>(0, count + from);
  Value list = Value::array();
  for (std::int64_t i = from; i < count; ++i) list.push_back(lines[static_cast<std::size_t>(i)]);
  return list;
}

// {"uuid": ..., "status": ...} and so on, as GET /task/{uuid}/info answers it, without output.
Result<Value> DescribeTask(Service& service, const storage::NodeTask& task) {
  SKYQUILT_TRY_ASSIGN(const storage::Flight flight, service.catalogue.GetFlight(task.flight_id));
  SKYQUILT_TRY_ASSIGN(const std::optional<storage::Job> job, service.queue.LatestOf(task.flight_id));
  Value answer;
  answer["uuid"] = task.uuid;
  answer["name"] = flight.name;
  answer["dateCreated"] = task.created_ms;
  answer["processingTime"] = ProcessingMs(job);
  SKYQUILT_TRY_ASSIGN(const int code, StatusCode(service, task, job));
  answer["status"] = {{"code", code}};
  if (code == 30) answer["status"]["errorMessage"] = job->error ? job->error->message : "Processing failed";
  answer["options"] = ParseOrderedJson(task.options);
  answer["imagesCount"] = flight.file_count;
  answer["progress"] = code == 40 ? 100.0 : job ? std::min(99.0, job->progress * 100.0) : 0.0;
  return answer;
}

Result<Response> TaskInfo(Service& service, const Request& request) {
  SKYQUILT_TRY_ASSIGN(const storage::NodeTask task, FindNodeTask(service, request.Parameter("uuid")));
  SKYQUILT_TRY_ASSIGN(Value answer, DescribeTask(service, task));
  if (const auto first_line = request.Query("with_output")) {
    SKYQUILT_TRY_ASSIGN(const std::vector<std::string> lines, NodeOutput(service, task));
    answer["output"] = LinesFrom(lines, ParseNumber<std::int64_t>(*first_line).value_or(0));
  }
  return NodeAnswer(JsonText(answer));
}

Result<Response> TaskOutput(Service& service, const Request& request) {
  SKYQUILT_TRY_ASSIGN(const storage::NodeTask task, FindNodeTask(service, request.Parameter("uuid")));
  SKYQUILT_TRY_ASSIGN(const std::vector<std::string> lines, NodeOutput(service, task));
  return NodeAnswer(
      JsonText(LinesFrom(lines, ParseNumber<std::int64_t>(request.Query("line").value_or("0")).value_or(0))));
}

std::string LineOf(const storage::Event& event) {
  const Value body = ParseOrderedJson(event.body);
  const std::string state = body.value("state", "");
  const std::string stage = body.value("stage", "");
  std::string text = "job " + state;
  if (state == "running" && !stage.empty()) text = "stage " + stage;
  if (body.contains("error") && body["error"].is_string()) text += ": " + body["error"].get<std::string>();
  return fmt::format("[{}] {}", FormatTime(event.at), text);
}

}  // namespace

bool IsNodeEngine(std::string_view name) {
  constexpr std::size_t kMaxLength = 32;
  const auto fits = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9'); };
  return !name.empty() && name.size() <= kMaxLength && std::all_of(name.begin(), name.end(), fits);
}

Result<storage::NodeTask> FindNodeTask(Service& service, std::string_view text) {
  const Error unknown{ErrorCode::kNotFound, fmt::format("{} not found", text)};
  const std::optional<std::string> uuid = NodeUuid(text);
  if (!uuid) return unknown;
  Result<storage::NodeTask> task = service.node_tasks.Find(*uuid);
  if (!task && task.error().code != ErrorCode::kNotFound) return task.error();
  if (!task || !task->is_committed) return unknown;
  return task;
}

Result<std::vector<std::string>> NodeOutput(Service& service, const storage::NodeTask& task) {
  SKYQUILT_TRY_ASSIGN(const std::optional<storage::Job> job, service.queue.LatestOf(task.flight_id));
  std::vector<std::string> lines;
  std::istringstream notes(task.notes);
  for (std::string line; std::getline(notes, line);) lines.push_back(line);
  if (!job) return lines;
  SKYQUILT_TRY_ASSIGN(const std::vector<storage::Event> events, service.events.OfJob(job->id));
  for (const storage::Event& event : events) lines.push_back(LineOf(event));
  return lines;
}

Result<std::string> NodeWebhookBody(Service& service, const std::string& uuid, const std::string& job_id) {
  SKYQUILT_TRY_ASSIGN(const storage::NodeTask task, FindNodeTask(service, uuid));
  SKYQUILT_TRY_ASSIGN(const std::optional<storage::Job> job, service.queue.LatestOf(task.flight_id));
  if (!job || job->id != job_id) return Error{ErrorCode::kNotFound, "The task was started again."};
  SKYQUILT_TRY_ASSIGN(Value body, DescribeTask(service, task));
  SKYQUILT_TRY_ASSIGN(const std::vector<storage::StoredFile> files,
                      service.catalogue.ListFiles(task.flight_id));
  body["images"] = Value::array();
  for (const storage::StoredFile& file : files)
    body["images"].push_back({{"filename", file.name}, {"size", file.bytes}});
  return JsonText(body);
}

void AddNodeRoutes(Router& router, Service& service) {
  router.Add(Method::kGet, "/info", On(service, Info));
  router.AddQuick(Method::kGet, "/options", [](const Request&) { return NodeAnswer(NodeOptionsJson()); });
  router.Add(Method::kGet, "/task/list", On(service, ListTasks, NodeProblem));
  router.Add(Method::kGet, "/task/{uuid}/info", On(service, TaskInfo, NodeProblem));
  router.Add(Method::kGet, "/task/{uuid}/output", On(service, TaskOutput, NodeProblem));
  router.AddQuick(Method::kGet, "/auth/info", On(service, AuthInfo)).scope = kEverybody;
  for (const char* pattern : {"/auth/login", "/auth/register"}) {
    router
        .AddBody(Method::kPost, pattern,
                 [](const Request&, const std::string&) { return NodeRefusal("Not available"); })
        .scope = kEverybody;
  }
}

}  // namespace skyquilt::api
