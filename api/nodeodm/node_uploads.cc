#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "api/flights/flights.h"
#include "api/flights/trash.h"
#include "api/forms/multipart.h"
#include "api/http/responses.h"
#include "api/nodeodm/node_new_task.h"
#include "api/nodeodm/nodeodm.h"
#include "api/routes.h"
#include "api/uploads/form_receiver.h"
#include "core/base/text/json_io.h"
#include "core/base/try.h"

namespace skyquilt::api {
namespace {

const FormRules kNodeForm = {
    {"name", "options", "skipPostProcessing", "webhook", "outputs", "dateCreated", "zipurl"}, true};

Response UuidAnswer(const std::string& uuid, const std::vector<std::string>& ignored_options = {}) {
  nlohmann::ordered_json answer = {{"uuid", uuid}};
  if (!ignored_options.empty()) answer["ignoredOptions"] = ignored_options;
  return NodeAnswer(JsonText(answer));
}

// A form that the node reads to its end whatever is wrong with it: a client that is cut off in the middle of
// its upload takes that for a passing fault and sends everything again.
class NodeForm : public BodySink {
 public:
  NodeForm(Service& service, Request request, const std::string& boundary, const std::string& flight_id)
      : service_(service),
        request_(std::move(request)),
        receiver_(service, flight_id, kNodeForm),
        parser_(boundary, receiver_) {}

  Result<void> Write(std::span<const std::uint8_t> bytes) override {
    if (failure_) return {};
    const Result<void> pushed = parser_.Push(bytes);
    if (!pushed) failure_ = pushed.error();
    return {};
  }

  Response Finish() override {
    if (!failure_) {
      const Result<void> whole = parser_.Finish();
      if (!whole) failure_ = whole.error();
    }
    Result<Response> answer = failure_ ? Result<Response>(*failure_) : Taken();
    return answer ? *std::move(answer) : NodeProblem(answer.error(), request_);
  }

 protected:
  virtual Result<Response> Taken() = 0;

  // Files that could not be taken, each in one sentence.
  std::vector<std::string> RefusedFiles() const {
    std::vector<std::string> refused;
    for (const FileOutcome& file : receiver_.files()) {
      if (file.error) refused.push_back(NodeNote(file.name + " was left out: " + file.error->message));
    }
    return refused;
  }

  // Why the node has nothing to begin with.
  std::string NoFile() const {
    std::string why = "Need at least 1 file.";
    if (const std::vector<std::string> refused = RefusedFiles(); !refused.empty())
      why += " " + refused.front();
    return why;
  }

  Service& service_;
  Request request_;
  FormReceiver receiver_;

 private:
  MultipartParser parser_;
  std::optional<Error> failure_;
};

// The fields of a form that came to its end.
NodeFields FieldsOf(const FormReceiver& form) {
  NodeFields fields;
  for (const std::string_view name : kNodeForm.text_fields) {
    if (auto text = form.Text(name)) fields.emplace(name, *std::move(text));
  }
  return fields;
}

// A task whose files are still to come.
Result<Response> CreateTask(Service& service, const Request& request, const NodeFields& fields) {
  SKYQUILT_TRY_ASSIGN(const NewTask task, NewTaskFrom(service, request, fields));
  SKYQUILT_TRY_ASSIGN(
      const storage::Flight flight,
      service.catalogue.AddFlight(task.name, task.choice.job_options, storage::Now(), request.owner));
  const Result<void> added = service.node_tasks.Add(task.Record(flight.id));
  if (!added) {
    SKYQUILT_TRY(RemoveFlight(service, flight.id));
    return added.error();
  }
  return UuidAnswer(task.uuid, task.choice.unknown);
}

class InitForm final : public NodeForm {
 public:
  using NodeForm::NodeForm;

 private:
  Result<Response> Taken() override { return CreateTask(service_, request_, FieldsOf(receiver_)); }
};

class UploadForm final : public NodeForm {
 public:
  using NodeForm::NodeForm;

 private:
  Result<Response> Taken() override {
    if (receiver_.files().empty()) return NodeRefusal(NoFile(), true);
    // One bad file of many is no reason to end the task: what came of it says so.
    for (const std::string& refused : RefusedFiles())
      SKYQUILT_TRY(service_.node_tasks.AddNote(*NodeUuid(request_.Parameter("uuid")), refused));
    return NodeAnswer(R"({"success":true})");
  }
};

// All at once: the flight is there before its fields are known, and goes again if they are not good.
class WholeForm final : public NodeForm {
 public:
  WholeForm(Service& service, Request request, const std::string& boundary, const std::string& flight_id)
      : NodeForm(service, std::move(request), boundary, flight_id), flight_id_(flight_id) {}
  ~WholeForm() override {
    // A flight that cannot be deleted now shows as one without a job; its owner can delete it.
    if (!is_kept_) (void)RemoveFlight(service_, flight_id_).ok();
  }

 private:
  Result<Response> Taken() override {
    SKYQUILT_TRY_ASSIGN(const NewTask task, NewTaskFrom(service_, request_, FieldsOf(receiver_)));
    if (receiver_.stored_count() == 0) return NodeRefusal(NoFile(), true);
    SKYQUILT_TRY(Start(task));
    is_kept_ = true;
    return UuidAnswer(task.uuid, task.choice.unknown);
  }

  Result<void> Start(const NewTask& task) {
    SKYQUILT_TRY(
        service_.catalogue.ChangeFlight(flight_id_, {.name = task.name, .options = task.choice.job_options}));
    storage::NodeTask record = task.Record(flight_id_);
    record.is_committed = true;
    for (const std::string& refused : RefusedFiles()) record.notes += refused + "\n";
    SKYQUILT_TRY(service_.node_tasks.Add(record));
    SKYQUILT_TRY(
        service_.queue.Add(flight_id_, task.choice.job_options, storage::Now(), {0, request_.owner}));
    return {};
  }

  std::string flight_id_;
  bool is_kept_ = false;
};

// Some clients send no file with this, and therefore no form of that kind.
UploadBegun BeginInit(Service& service, const Request& request) {
  const std::string_view type = request.headers.Find("Content-Type");
  const Result<std::string> boundary = MultipartBoundary(type);
  if (!boundary && boundary.error().code == ErrorCode::kUnsupportedFormat) {
    return CollectBody(request, [&service](const Request& of, const std::string& body) {
      const Result<NodeFields> fields = ParseNodeFields(of.headers.Find("Content-Type"), body);
      Result<Response> made = fields ? CreateTask(service, of, *fields) : fields.error();
      return made ? *std::move(made) : NodeProblem(made.error(), of);
    });
  }
  if (!boundary) return boundary.error();
  return std::make_unique<InitForm>(service, request, *boundary, "");
}

Error InvalidUuid() { return {ErrorCode::kNotFound, "Invalid uuid (not found)"}; }

// Committed or not.
Result<storage::NodeTask> FindAnyTask(Service& service, const Request& request) {
  const std::optional<std::string> uuid = NodeUuid(request.Parameter("uuid"));
  if (!uuid) return InvalidUuid();
  Result<storage::NodeTask> task = service.node_tasks.Find(*uuid);
  if (!task && task.error().code == ErrorCode::kNotFound) return InvalidUuid();
  return task;
}

UploadBegun BeginUpload(Service& service, const Request& request) {
  SKYQUILT_TRY_ASSIGN(const storage::NodeTask task, FindAnyTask(service, request));
  if (task.is_committed) return InvalidUuid();
  const Result<std::string> boundary = MultipartBoundary(request.headers.Find("Content-Type"));
  if (!boundary) return NodeRefusal("Need at least 1 file.", true);
  return std::make_unique<UploadForm>(service, request, *boundary, task.flight_id);
}

UploadBegun BeginWhole(Service& service, const Request& request) {
  SKYQUILT_TRY_ASSIGN(const std::string boundary, MultipartBoundary(request.headers.Find("Content-Type")));
  const storage::Time now = storage::Now();
  SKYQUILT_TRY_ASSIGN(const storage::Flight flight,
                      service.catalogue.AddFlight(DefaultFlightName(now), "{}", now, request.owner));
  return std::make_unique<WholeForm>(service, request, boundary, flight.id);
}

Result<Response> Commit(Service& service, const Request& request) {
  SKYQUILT_TRY_ASSIGN(const storage::NodeTask task, FindAnyTask(service, request));
  if (!task.is_committed) {
    SKYQUILT_TRY_ASSIGN(const storage::Flight flight, service.catalogue.GetFlight(task.flight_id));
    if (flight.file_count == 0) {
      const std::string first_note = task.notes.substr(0, task.notes.find('\n'));
      return NodeRefusal("Need at least 1 file." + (first_note.empty() ? "" : " " + first_note), true);
    }
    // The job first: a commit that breaks in between is made good by the client's next try.
    const Result<storage::Job> job =
        service.queue.Add(task.flight_id, flight.options, storage::Now(), {0, request.owner});
    if (!job && job.error().code != ErrorCode::kConflict) return job.error();
    SKYQUILT_TRY(service.node_tasks.Commit(task.uuid));
  }
  return UuidAnswer(task.uuid);
}

}  // namespace

void AddNodeUploadRoutes(Router& router, Service& service) {
  router.AddUpload(Method::kPost, "/task/new/init", On(service, BeginInit, NodeProblem));
  router.AddUpload(Method::kPost, "/task/new/upload/{uuid}", On(service, BeginUpload, NodeProblem));
  router.AddUpload(Method::kPost, "/task/new", On(service, BeginWhole, NodeProblem));
  router.AddBody(Method::kPost, "/task/new/commit/{uuid}",
                 [commit = On(service, Commit, NodeProblem)](const Request& request, const std::string&) {
                   return commit(request);
                 });
}

}  // namespace skyquilt::api
