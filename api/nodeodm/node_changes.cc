#include <nlohmann/json.hpp>

#include "api/auth/flight_access.h"
#include "api/flights/trash.h"
#include "api/http/responses.h"
#include "api/http/target.h"
#include "api/json/json_text.h"
#include "api/nodeodm/node_options.h"
#include "api/nodeodm/nodeodm.h"
#include "core/base/try.h"

namespace skyquilt::api {
namespace {

using PlainJson = nlohmann::json;

struct TaskRequest {
  std::string uuid;
  std::optional<std::string> options;  // JSON list
  std::string owner;                   // id of the request's token
};

// Clients send these as a form or as JSON.
Result<TaskRequest> ParseTaskRequest(const Request& request, const std::string& body) {
  TaskRequest wanted;
  wanted.owner = request.owner;
  const std::string_view type = request.headers.Find("Content-Type");
  if (EqualsIgnoringCase(type.substr(0, type.find_first_of("; ")), "application/json")) {
    SKYQUILT_TRY(CheckJsonText(body));
    const PlainJson parsed = PlainJson::parse(body, nullptr, false);
    if (!parsed.is_object()) return Error{ErrorCode::kInvalidArgument, "The body is not a JSON object.", ""};
    if (parsed.contains("uuid") && parsed["uuid"].is_string()) wanted.uuid = parsed["uuid"];
    if (parsed.contains("options")) {
      const PlainJson& options = parsed["options"];
      wanted.options = options.is_string() ? options.get<std::string>() : options.dump();
    }
  } else {
    SKYQUILT_TRY_ASSIGN(const auto fields, ParseQuery(body));
    for (const auto& [name, value] : fields) {
      if (name == "uuid") wanted.uuid = value;
      if (name == "options" && !value.empty()) wanted.options = value;
    }
  }
  if (wanted.uuid.empty()) return Error{ErrorCode::kInvalidArgument, "uuid param missing.", ""};
  return wanted;
}

Response Outcome(const Result<void>& done, const Request& request) {
  if (done) return NodeAnswer(R"({"success":true})");
  Response response = NodeProblem(done.error(), request);
  if (response.status == 200) {
    response.body = PlainJson{{"success", false}, {"error", done.error().message}}.dump(
        -1, ' ', false, PlainJson::error_handler_t::replace);
  }
  return response;
}

Result<void> CancelTask(Service& service, const storage::NodeTask& task) {
  SKYQUILT_TRY_ASSIGN(const std::optional<storage::Job> job, service.queue.LatestOf(task.flight_id));
  if (!job) return {};
  const Result<storage::Job> cancelled = service.queue.Cancel(job->id, storage::Now());
  // A task that has ended cannot be stopped any more; the request is not an error.
  if (!cancelled && cancelled.error().code != ErrorCode::kConflict) return cancelled.error();
  return {};
}

Result<void> RemoveTask(Service& service, const storage::NodeTask& task) {
  return DeleteFlight(service, task.flight_id);
}

Result<void> RestartTask(Service& service, const storage::NodeTask& task, const TaskRequest& wanted) {
  SKYQUILT_TRY_ASSIGN(const std::optional<storage::Job> job, service.queue.LatestOf(task.flight_id));
  if (!job || !job->finished) {
    return Error{ErrorCode::kConflict, "Cannot be restarted: the task has not ended.", ""};
  }
  SKYQUILT_TRY_ASSIGN(const storage::Flight flight, service.catalogue.GetFlight(task.flight_id));
  NodeChoice choice{flight.options, task.options, {}};
  if (wanted.options) {
    SKYQUILT_TRY_ASSIGN(const NodeChoice parsed, ParseNodeOptions(*wanted.options));
    choice = parsed;
    SKYQUILT_TRY(service.catalogue.SetFlightOptions(task.flight_id, choice.job_options));
  }
  const Result<storage::Job> queued =
      service.queue.Add(task.flight_id, choice.job_options, storage::Now(), {0, wanted.owner});
  if (!queued) return queued.error();
  for (const std::string& note : NodeNotes(choice.unknown)) {
    SKYQUILT_TRY(service.node_tasks.AddNote(task.uuid, note));
  }
  return service.node_tasks.Restart(task.uuid, choice.shown, NodeNowMs());
}

using Change = std::function<Result<void>(const storage::NodeTask&, const TaskRequest&)>;

void AddChange(Router& router, Service& service, const char* pattern, Change change) {
  router.AddUpload(Method::kPost, pattern,
                   [&service, change = std::move(change)](
                       const Request& request) -> std::variant<std::unique_ptr<BodySink>, Response> {
                     return CollectBody([&service, change, request](const std::string& body) {
                       const Result<TaskRequest> wanted = ParseTaskRequest(request, body);
                       if (!wanted) return NodeProblem(wanted.error(), request);
                       const Result<storage::NodeTask> task = FindNodeTask(service, wanted->uuid);
                       if (!task) return Outcome(task.error(), request);
                       const Result<void> may = CheckMayChange(service, request, task->flight_id);
                       if (!may) return Outcome(may.error(), request);
                       return Outcome(change(*task, *wanted), request);
                     });
                   });
}

}  // namespace

void AddNodeChangeRoutes(Router& router, Service& service) {
  AddChange(router, service, "/task/cancel",
            [&](const storage::NodeTask& task, const TaskRequest&) { return CancelTask(service, task); });
  AddChange(router, service, "/task/remove",
            [&](const storage::NodeTask& task, const TaskRequest&) { return RemoveTask(service, task); });
  AddChange(router, service, "/task/restart", [&](const storage::NodeTask& task, const TaskRequest& wanted) {
    return RestartTask(service, task, wanted);
  });
}

}  // namespace skyquilt::api
