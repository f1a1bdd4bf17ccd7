#include <chrono>
#include <nlohmann/json.hpp>
#include <thread>

#include "api/auth/flight_access.h"
#include "api/flights/trash.h"
#include "api/http/responses.h"
#include "api/nodeodm/node_new_task.h"
#include "api/nodeodm/node_options.h"
#include "api/nodeodm/nodeodm.h"
#include "api/routes.h"
#include "core/base/text/json_io.h"
#include "core/base/try.h"

namespace skyquilt::api {
namespace {

using PlainJson = nlohmann::json;

constexpr std::chrono::seconds kStopPatience{5};
constexpr std::chrono::milliseconds kLookAgain{50};

struct TaskRequest {
  std::string uuid;
  std::optional<std::string> options;  // JSON list
  std::string owner;                   // id of the request's token
};

// Clients send these as a form of either kind or as JSON.
Result<TaskRequest> ParseTaskRequest(const Request& request, const std::string& body) {
  SKYQUILT_TRY_ASSIGN(const NodeFields fields, ParseNodeFields(request.headers.Find("Content-Type"), body));
  TaskRequest wanted;
  wanted.owner = request.owner;
  wanted.uuid = NodeField(fields, "uuid");
  if (const std::string options = NodeField(fields, "options"); !options.empty()) wanted.options = options;
  if (wanted.uuid.empty()) return Error{ErrorCode::kInvalidArgument, "uuid param missing."};
  return wanted;
}

Response Outcome(const Result<void>& done, const Request& request) {
  if (done) return NodeAnswer(R"({"success":true})");
  Response response = NodeProblem(done.error(), request);
  if (response.status == 200) {
    response.body = JsonText(PlainJson{{"success", false}, {"error", done.error().message}});
  }
  return response;
}

// As the original has it, a task is cancelled from here on, whatever has become of it: its client is told so
// at once, and may restart it.
Result<void> CancelTask(Service& service, const storage::NodeTask& task) {
  SKYQUILT_TRY_ASSIGN(const std::optional<storage::Job> job, service.queue.LatestOf(task.flight_id));
  if (!job) return {};
  SKYQUILT_TRY(service.node_tasks.MarkCanceled(task.uuid, job->id));
  const Result<storage::Job> cancelled = service.queue.Cancel(job->id, storage::Now());
  if (!cancelled && cancelled.error().code != ErrorCode::kConflict) return cancelled.error();
  return {};
}

// The task's latest job; one that was cancelled may take a moment to end.
Result<std::optional<storage::Job>> LatestJobAtRest(Service& service, const storage::NodeTask& task) {
  const auto end = std::chrono::steady_clock::now() + kStopPatience;
  while (true) {
    SKYQUILT_TRY_ASSIGN(std::optional<storage::Job> job, service.queue.LatestOf(task.flight_id));
    const bool is_stopping = job && !job->finished && job->cancel_requested;
    if (!is_stopping || service.is_draining || std::chrono::steady_clock::now() > end) return job;
    std::this_thread::sleep_for(kLookAgain);
  }
}

Result<void> RestartTask(Service& service, const storage::NodeTask& task, const TaskRequest& wanted) {
  SKYQUILT_TRY_ASSIGN(const std::optional<storage::Job> job, LatestJobAtRest(service, task));
  if (!job || !job->finished) {
    return Error{ErrorCode::kConflict, "Cannot be restarted: the task has not ended. Cancel it or wait."};
  }
  SKYQUILT_TRY_ASSIGN(const storage::Flight flight, service.catalogue.GetFlight(task.flight_id));
  NodeChoice choice{flight.options, task.options, {}};
  if (wanted.options) {
    SKYQUILT_TRY_ASSIGN(const NodeChoice parsed, ParseNodeOptions(*wanted.options));
    choice = parsed;
    SKYQUILT_TRY(service.catalogue.ChangeFlight(task.flight_id, {.options = choice.job_options}));
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
  router.AddBody(
      Method::kPost, pattern,
      [&service, change = std::move(change)](const Request& request, const std::string& body) -> Response {
        const Result<TaskRequest> wanted = ParseTaskRequest(request, body);
        if (!wanted) return NodeProblem(wanted.error(), request);
        const Result<storage::NodeTask> task = FindNodeTask(service, wanted->uuid);
        if (!task) return Outcome(task.error(), request);
        const Result<void> may = CheckMayChange(service, request, task->flight_id);
        if (!may) return Outcome(may.error(), request);
        return Outcome(change(*task, *wanted), request);
      });
}

}  // namespace

void AddNodeChangeRoutes(Router& router, Service& service) {
  AddChange(router, service, "/task/cancel",
            [&](const storage::NodeTask& task, const TaskRequest&) { return CancelTask(service, task); });
  AddChange(router, service, "/task/remove", [&](const storage::NodeTask& task, const TaskRequest&) {
    return DeleteFlight(service, task.flight_id);
  });
  AddChange(router, service, "/task/restart", [&](const storage::NodeTask& task, const TaskRequest& wanted) {
    return RestartTask(service, task, wanted);
  });
}

}  // namespace skyquilt::api
