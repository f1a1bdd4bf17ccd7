#include "api/nodeodm/node_new_task.h"

#include <charconv>
#include <nlohmann/json.hpp>

#include "api/flights/flights.h"
#include "api/json/json_codec.h"
#include "api/json/json_text.h"
#include "api/nodeodm/nodeodm.h"
#include "api/webhooks/webhooks.h"
#include "core/base/text/json_io.h"
#include "core/base/try.h"

namespace skyquilt::api {

namespace {

// A webhook that cannot be told is no reason to refuse the task.
void SetWebhook(const Service& service, const std::string& url, NewTask& task) {
  if (url.empty()) return;
  if (!service.sends_webhooks) {
    task.notes.push_back(NodeNote("The webhook " + url +
                                  " will not be told: this node speaks to nobody by itself. Its operator "
                                  "changes that with serve --webhooks."));
  } else if (const Result<void> checked = CheckWebhookUrl(url); !checked) {
    task.notes.push_back(NodeNote("The webhook " + url + " will not be told: " + checked.error().message));
  } else {
    task.webhook = url;
  }
}

Result<void> SetOutputs(const std::string& text, NewTask& task) {
  if (text.empty()) return {};
  SKYQUILT_TRY(CheckJsonText(text));
  const auto list = ParseJson(text);
  bool is_good = list.is_array();
  for (const auto& path : list) is_good = is_good && path.is_string();
  if (!is_good) {
    return Error{ErrorCode::kInvalidArgument,
                 "Invalid outputs: give a JSON list of paths as all.zip has them.", ""};
  }
  task.outputs = JsonText(list);
  return {};
}

}  // namespace

storage::NodeTask NewTask::Record(const std::string& flight_id) const {
  storage::NodeTask record;
  record.uuid = uuid;
  record.flight_id = flight_id;
  record.options = choice.shown;
  record.created_ms = created_ms;
  record.webhook = webhook;
  record.outputs = outputs;
  for (const std::string& note : notes) record.notes += note + "\n";
  return record;
}

Result<NewTask> NewTaskFrom(Service& service, const Request& request, const NodeFields& fields) {
  NewTask task;
  const std::string_view wanted = request.headers.Find("set-uuid");
  task.uuid = NewNodeUuid();
  if (!wanted.empty()) {
    const std::optional<std::string> uuid = NodeUuid(wanted);
    if (!uuid)
      return Error{ErrorCode::kInvalidArgument, "Invalid uuid: set-uuid must be a UUID of version 1 to 7.",
                   ""};
    const Result<storage::NodeTask> taken = service.node_tasks.Find(*uuid);
    if (taken) return Error{ErrorCode::kConflict, "Invalid uuid: it is in use.", ""};
    if (taken.error().code != ErrorCode::kNotFound) return taken.error();
    task.uuid = *uuid;
  }
  if (NodeField(fields, "zipurl") != "") {
    return Error{ErrorCode::kUnprocessable,
                 "This node fetches nothing by itself (zipurl). Upload the photos.", ""};
  }
  SKYQUILT_TRY_ASSIGN(const NodeChoice choice, ParseNodeOptions(NodeField(fields, "options")));
  task.choice = choice;
  task.notes = NodeNotes(choice.unknown);
  SetWebhook(service, NodeField(fields, "webhook"), task);
  SKYQUILT_TRY(SetOutputs(NodeField(fields, "outputs"), task));
  task.name = NodeField(fields, "name");
  if (task.name.empty()) task.name = DefaultFlightName(storage::Now());
  const Result<storage::FlightChange> checked =
      ParseFlightFields(JsonObject({{"name", JsonString(task.name)}}));
  if (!checked) return checked.error();
  const std::string date = NodeField(fields, "dateCreated");
  task.created_ms = NodeNowMs();
  if (!date.empty()) {
    const auto parsed = std::from_chars(date.data(), date.data() + date.size(), task.created_ms);
    if (parsed.ec != std::errc() || parsed.ptr != date.data() + date.size()) task.created_ms = NodeNowMs();
  }
  return task;
}

}  // namespace skyquilt::api
